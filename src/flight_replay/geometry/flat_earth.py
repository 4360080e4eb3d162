"""ArduPilot's own flat earth: the metres in which it navigates.

Source: AP_Common/Location.cpp (get_vector_xy_from_origin_NE, offset_latlng): a degree of latitude
is the same everywhere, one of longitude shrinks with the cosine of the middle latitude. These
metres differ from ground metres by up to 0.5 %, and so do the durations of legs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flight_replay.geometry.arrays import Floats

METRES_PER_DEGREE = 111318.84502145034
# Location::longitude_scale.
_SMALLEST_SCALE = 0.01
# 32-bit, as on board: centimetres and radians of 1e-7 degree of latitude.
_CM_E7 = np.float32(METRES_PER_DEGREE * 1e-5)
_RADIANS_E7 = np.float32(1e-7) * (np.float32(np.pi) / np.float32(180.0))
_HALF_E7 = 1_800_000_000
# The C library's cosf (glibc's sysdeps/ieee754/flt-32/s_sincosf_data.c): coefficients of the even powers in
# the cosine near the equator, and of the odd ones in the sine of the angle to the pole.
_COSINE = (1.0, -0.49999999725108224, 0.041666623324344516, -0.001388676379437604, 2.4390450703564542e-05)
_SINE = (1.0, -0.16666654943701084, 0.008332178146138854, -0.00019517298981385725)


def _home_e7(degrees: float) -> int:
    """Degrees times 1e7 of a home, as the GPS that SITL simulates gives it."""
    return int(int(round(degrees, 7) * 1e7) * 1e-7 * 1e7)


def _cosf(latitude: Floats) -> Floats:
    """Cosine of 32-bit radians of latitude as ``cosf`` gives it: for one in 80 not the nearest number."""
    near = np.abs(latitude)
    far = np.pi / 2 - near
    return np.where(near < np.pi / 4, _power_series(_COSINE, near), far * _power_series(_SINE, far)).astype(
        np.float32
    )


def _power_series(coefficients: tuple[float, ...], angle: Floats) -> Floats:
    """Sum of even powers of an angle, times coefficients."""
    total = np.zeros_like(angle)
    for coefficient in reversed(coefficients):
        total = coefficient + total * angle * angle
    return total


def _scale(lat_deg: Floats) -> Floats:
    """Metres of a degree of longitude over those of one of latitude."""
    return np.asarray(np.maximum(np.cos(np.radians(lat_deg)), _SMALLEST_SCALE))


@dataclass(frozen=True, slots=True)
class FlatFrame:
    """ArduPilot's metres north and east of an origin in degrees."""

    lat_deg: float
    lon_deg: float

    def to_metres(self, lat_deg: ArrayLike, lon_deg: ArrayLike) -> Floats:
        """Metres (north, east), shape (..., 2), of positions in degrees."""
        lat, lon = np.asarray(lat_deg, float), np.asarray(lon_deg, float)
        turned = (lon - self.lon_deg + 180.0) % 360.0 - 180.0
        east = turned * METRES_PER_DEGREE * _scale((lat + self.lat_deg) / 2)
        return np.stack([(lat - self.lat_deg) * METRES_PER_DEGREE, east], axis=-1)

    def to_metres_on_board(self, lat_deg: ArrayLike, lon_deg: ArrayLike) -> Floats:
        """As ``to_metres``, rounded like on board: degrees to 1e-7, the sums to 32-bit centimetres.

        The origin is where SITL's GPS saw home: twice cut off at 1e-7 degrees (parse_home, GPS).
        """
        lat, lon = np.asarray(lat_deg, float), np.asarray(lon_deg, float)
        origin_lat, origin_lon = _home_e7(self.lat_deg), _home_e7(self.lon_deg)
        lat_e7 = np.rint(lat * 1e7).astype(np.int64)
        turned_e7 = (np.rint(lon * 1e7).astype(np.int64) - origin_lon + _HALF_E7) % (2 * _HALF_E7) - _HALF_E7
        middle = np.trunc((lat_e7 + origin_lat) / 2).astype(np.float32) * _RADIANS_E7
        scale = np.maximum(_cosf(middle.astype(float)), np.float32(_SMALLEST_SCALE))
        north = (lat_e7 - origin_lat).astype(np.float32) * _CM_E7
        east = turned_e7.astype(np.float32) * _CM_E7 * scale
        return np.stack([north, east], axis=-1).astype(float) / 100.0

    def to_degrees(self, north_east_m: ArrayLike) -> tuple[Floats, Floats]:
        """Latitude and longitude, degrees, of metres (..., 2); longitude within 180 either way."""
        metres = np.asarray(north_east_m, float)
        lat = self.lat_deg + metres[..., 0] / METRES_PER_DEGREE
        lon = self.lon_deg + metres[..., 1] / (METRES_PER_DEGREE * _scale((lat + self.lat_deg) / 2))
        return lat, (lon + 180.0) % 360.0 - 180.0
