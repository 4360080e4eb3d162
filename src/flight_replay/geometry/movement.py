"""Where a vehicle was at what time: what measures compare, whether recorded, predicted or flown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats, Indices

Degrees = TypeVar("Degrees", float, Floats)


@dataclass(frozen=True, slots=True, eq=False)
class Movement:
    """A vehicle at n times, in one local frame.

    ``time_s`` (n,) never falls; ``north_east_m`` (n, 2) are ground metres, ``up_m`` (n,) metres above
    home, ``heading_deg`` (n,) where the nose points; what is unknown of the last two is not a number.
    ``timed`` tells whether the times were recorded; without, they only keep the order.
    """

    time_s: Floats
    north_east_m: Floats
    up_m: Floats
    heading_deg: Floats
    timed: bool = True

    def __len__(self) -> int:
        return len(self.time_s)

    def select(self, keep: Flags | Indices | slice) -> Movement:
        """What a mask, an index array or a slice picks."""
        return Movement(
            self.time_s[keep], self.north_east_m[keep], self.up_m[keep], self.heading_deg[keep], self.timed
        )

    def places_at(self, times_s: Floats) -> Floats:
        """Ground positions (m, 2) at times (m,), on straight lines between those known; at least one is."""
        axes = [np.interp(times_s, self.time_s, axis) for axis in self.north_east_m.T]
        return np.column_stack(axes)

    def headings_at(self, times_s: Floats) -> Floats:
        """Headings (m,) at times (m,), the short way round between those known; elsewhere not a number."""
        known = np.isfinite(self.heading_deg)
        if not known.any():
            return np.full(len(times_s), np.nan)
        turned = np.unwrap(self.heading_deg[known], period=360.0)
        return np.interp(times_s, self.time_s[known], turned, left=np.nan, right=np.nan) % 360.0


def turn_deg(to_deg: Degrees, from_deg: Degrees) -> Degrees:
    """The short way from one heading to another, -180 to below 180; to the right is positive."""
    return (to_deg - from_deg + 180.0) % 360.0 - 180.0
