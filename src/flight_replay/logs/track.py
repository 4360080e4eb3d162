"""A recorded or flown track: fixes of one vehicle as columns of equal length, in SI units."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Flags, Floats, Indices
from flight_replay.geometry.geodesy import LocalFrame, surface_xyz_m
from flight_replay.geometry.polyline import segment_lengths_m

UNTIMED_SPEED_M_S = 5.0
"""The ground speed that tracks without times are taken to be flown at: that of many missions."""


class Armed(IntEnum):
    """What the log tells of the motors at a fix."""

    UNKNOWN = -1
    NO = 0
    YES = 1


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Fixes in the order of time; every column has shape (n,).

    ``time_s`` is the vehicle's own clock (``time_boot_ms``; log stamps where that stands still),
    carried on over reboots, so that it never falls within a track; ``alt_m`` is height above home,
    ``amsl_m`` above mean sea level; velocities are m/s; ``heading_deg`` is where the nose points,
    clockwise from north, not a number where unknown; ``boot`` numbers the boots from 0; ``armed``
    holds ``Armed`` values. A track that is not ``timed`` was recorded without times: its ``time_s``
    counts as if it had been flown at ``UNTIMED_SPEED_M_S`` all along.
    """

    time_s: Floats
    lat_deg: Floats
    lon_deg: Floats
    alt_m: Floats
    amsl_m: Floats
    north_m_s: Floats
    east_m_s: Floats
    up_m_s: Floats
    heading_deg: Floats
    boot: NDArray[np.int32]
    armed: NDArray[np.int8]
    timed: bool = True

    def __len__(self) -> int:
        return len(self.time_s)

    def select(self, keep: Indices | Flags | slice) -> Track:
        """The fixes that a mask, a slice or an index array picks, in that order."""
        if isinstance(keep, np.ndarray) and keep.dtype == np.bool_ and keep.all():
            return self
        columns = {name: getattr(self, name)[keep] for name in COLUMNS}
        return Track(**columns, timed=self.timed)

    @property
    def frame(self) -> LocalFrame:
        """The local metric frame around the first fix."""
        return LocalFrame(float(self.lat_deg[0]), float(self.lon_deg[0]))

    def north_east_m(self, frame: LocalFrame | None = None) -> Floats:
        """Ground positions (n, 2) in metres north and east of the frame's origin (first fix)."""
        return (frame or self.frame).to_metres(self.lat_deg, self.lon_deg)

    @property
    def steps_m(self) -> Floats:
        """Ground distances from fix to fix (n - 1,), metres."""
        return segment_lengths_m(surface_xyz_m(self.lat_deg, self.lon_deg))

    @property
    def length_m(self) -> float:
        """Ground distance along the fixes, metres."""
        return float(self.steps_m.sum())


COLUMNS = tuple(field.name for field in fields(Track) if field.name != "timed")
"""The names of a track's columns."""


def track_from_columns(  # noqa: PLR0913
    time_s: Floats,
    lat_deg: Floats,
    lon_deg: Floats,
    alt_m: Floats,
    *,
    amsl_m: Floats | None = None,
    velocity_m_s: Floats | None = None,
    heading_deg: Floats | None = None,
    boot: NDArray[np.int32] | None = None,
    armed: NDArray[np.int8] | None = None,
) -> Track:
    """A track from what is known: missing heights are ``alt_m``, what else is missing is not a number.

    Args:
        time_s: Times (n,); ``Track`` has the units of all columns.
        lat_deg: Latitudes (n,).
        lon_deg: Longitudes (n,).
        alt_m: Heights above home (n,).
        amsl_m: Heights above mean sea level (n,).
        velocity_m_s: Velocities north, east and up (n, 3).
        heading_deg: Headings (n,).
        boot: Numbers of the boots (n,), by default one boot.
        armed: ``Armed`` values (n,), by default unknown.
    """
    n = len(time_s)
    velocity = np.full((n, 3), np.nan) if velocity_m_s is None else velocity_m_s
    return Track(
        time_s=np.asarray(time_s, float),
        lat_deg=np.asarray(lat_deg, float),
        lon_deg=np.asarray(lon_deg, float),
        alt_m=np.asarray(alt_m, float),
        amsl_m=np.asarray(alt_m if amsl_m is None else amsl_m, float),
        north_m_s=velocity[:, 0],
        east_m_s=velocity[:, 1],
        up_m_s=velocity[:, 2],
        heading_deg=np.full(n, np.nan) if heading_deg is None else np.asarray(heading_deg, float),
        boot=np.zeros(n, np.int32) if boot is None else boot,
        armed=np.full(n, Armed.UNKNOWN, np.int8) if armed is None else armed,
    )
