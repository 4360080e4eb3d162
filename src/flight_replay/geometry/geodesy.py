"""Degrees on the WGS 84 ellipsoid to metres in a local frame, and back.

Heights play no part: every position is taken on the ellipsoid's surface, so distances are ground
distances. The frame is the tangent plane of its origin, stretched radially to ground distance
(azimuthal equidistant to second order): distances within 10 km of the origin are good to
1 mm/km at any latitude, at the poles and across the antimeridian.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from flight_replay.geometry.arrays import Floats

# WGS 84 defining constants, NIMA TR8350.2.
EQUATORIAL_RADIUS_M = 6378137.0
FLATTENING = 1 / 298.257223563
_POLAR_RADIUS_M = EQUATORIAL_RADIUS_M * (1 - FLATTENING)
_ECCENTRICITY_SQUARED = FLATTENING * (2 - FLATTENING)
_TINY = 1e-300
"""Keeps 0 / 0 at the origin a number; what is multiplied with it is 0 there."""


def surface_xyz_m(lat_deg: ArrayLike, lon_deg: ArrayLike) -> Floats:
    """Earth-centred coordinates of positions on the ellipsoid, shape (..., 3), metres."""
    lat, lon = np.radians(np.asarray(lat_deg, float)), np.radians(np.asarray(lon_deg, float))
    prime_vertical_m = EQUATORIAL_RADIUS_M / np.sqrt(1 - _ECCENTRICITY_SQUARED * np.sin(lat) ** 2)
    return np.stack(
        [
            prime_vertical_m * np.cos(lat) * np.cos(lon),
            prime_vertical_m * np.cos(lat) * np.sin(lon),
            prime_vertical_m * (1 - _ECCENTRICITY_SQUARED) * np.sin(lat),
        ],
        axis=-1,
    )


def distance_m(lat1_deg: ArrayLike, lon1_deg: ArrayLike, lat2_deg: ArrayLike, lon2_deg: ArrayLike) -> Floats:
    """Ground distance between positions, metres: the straight chord, 1 mm/km short at 31 km."""
    step = surface_xyz_m(lat2_deg, lon2_deg) - surface_xyz_m(lat1_deg, lon1_deg)
    return np.asarray(np.linalg.norm(step, axis=-1))


class Place(Protocol):
    """What is somewhere."""

    @property
    def lat_deg(self) -> float:
        """Latitude, degrees."""

    @property
    def lon_deg(self) -> float:
        """Longitude, degrees."""


def ground_distance_m(here: Place, there: Place) -> float:
    """How far one place is from another over the ground, see ``distance_m``."""
    return float(distance_m(here.lat_deg, here.lon_deg, there.lat_deg, there.lon_deg))


@dataclass(frozen=True, slots=True)
class LocalFrame:
    """A metric frame, north and east of an origin given in degrees."""

    lat_deg: float
    lon_deg: float

    def _axes(self) -> tuple[Floats, Floats]:
        """The origin (3,) and the rows east, north, up (3, 3) of its tangent plane."""
        lat, lon = np.radians(self.lat_deg), np.radians(self.lon_deg)
        east = [-np.sin(lon), np.cos(lon), 0.0]
        north = [-np.sin(lat) * np.cos(lon), -np.sin(lat) * np.sin(lon), np.cos(lat)]
        up = [np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)]
        return surface_xyz_m(self.lat_deg, self.lon_deg), np.array([east, north, up])

    def to_metres(self, lat_deg: ArrayLike, lon_deg: ArrayLike) -> Floats:
        """Metres (north, east) from the origin, shape (..., 2)."""
        origin, axes = self._axes()
        plane = (surface_xyz_m(lat_deg, lon_deg) - origin) @ axes[:2].T
        # A sphere's tangent plane shows ground distance d as R sin(d / R).
        sine = np.minimum(np.linalg.norm(plane, axis=-1, keepdims=True) / EQUATORIAL_RADIUS_M, 1.0)
        stretched = plane * (np.arcsin(sine) / np.maximum(sine, _TINY))
        return np.asarray(stretched[..., ::-1])

    def to_degrees(self, north_east_m: ArrayLike) -> tuple[Floats, Floats]:
        """Latitude and longitude, degrees, of metres (..., 2) from the origin."""
        origin, axes = self._axes()
        stretched = np.asarray(north_east_m, float)[..., ::-1]
        angle = np.linalg.norm(stretched, axis=-1, keepdims=True) / EQUATORIAL_RADIUS_M
        plane = stretched * (np.sin(angle) / np.maximum(angle, _TINY))
        xyz = _drop_to_surface(origin + plane @ axes[:2], axes[2])
        flat = np.hypot(xyz[..., 0], xyz[..., 1])
        lat = np.arctan2(xyz[..., 2], flat * (1 - _ECCENTRICITY_SQUARED))
        return np.degrees(lat), np.degrees(np.arctan2(xyz[..., 1], xyz[..., 0]))


def _drop_to_surface(xyz: Floats, up: Floats) -> Floats:
    """Move points (..., 3) along ``up`` onto the ellipsoid: the nearer root of its quadratic."""
    scale = np.array([EQUATORIAL_RADIUS_M, EQUATORIAL_RADIUS_M, _POLAR_RADIUS_M])
    point, direction = xyz / scale, up / scale
    a = direction @ direction
    b = point @ direction
    c = (point * point).sum(axis=-1) - 1
    shift = (np.sqrt(np.maximum(b * b - a * c, 0)) - b) / a
    return np.asarray(xyz + shift[..., None] * up)
