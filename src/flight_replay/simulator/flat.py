"""ArduPilot's own flat earth: the metres in which it navigates.

Source: AP_Common/Location.cpp (get_vector_xy_from_origin_NE, offset_latlng): a degree of latitude
is the same everywhere, one of longitude shrinks with the cosine of the middle latitude. These
metres differ from ground metres by up to 0.5 %, and so do the durations of legs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flight_replay.geodesy import Floats

METRES_PER_DEGREE = 111318.84502145034
# Location::longitude_scale.
_SMALLEST_SCALE = 0.01


def _scale(lat_deg: Floats) -> Floats:
    """Metres of a degree of longitude over those of one of latitude."""
    return np.asarray(np.maximum(np.cos(np.radians(lat_deg)), _SMALLEST_SCALE))


@dataclass(frozen=True, slots=True)
class FlatFrame:
    """ArduPilot's metres north and east of an origin in degrees."""

    lat_deg: float
    lon_deg: float

    def to_metres(self, lat_deg: ArrayLike, lon_deg: ArrayLike) -> Floats:
        """Metres (north, east), shape (..., 2), of places in degrees."""
        lat, lon = np.asarray(lat_deg, float), np.asarray(lon_deg, float)
        turned = (lon - self.lon_deg + 180.0) % 360.0 - 180.0
        east = turned * METRES_PER_DEGREE * _scale((lat + self.lat_deg) / 2)
        return np.stack([(lat - self.lat_deg) * METRES_PER_DEGREE, east], axis=-1)

    def to_degrees(self, north_east_m: ArrayLike) -> tuple[Floats, Floats]:
        """Latitude and longitude, degrees, of metres (..., 2); longitude within 180 either way."""
        metres = np.asarray(north_east_m, float)
        lat = self.lat_deg + metres[..., 0] / METRES_PER_DEGREE
        lon = self.lon_deg + metres[..., 1] / (METRES_PER_DEGREE * _scale((lat + self.lat_deg) / 2))
        return lat, (lon + 180.0) % 360.0 - 180.0
