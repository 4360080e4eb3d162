"""The points of a track as its file gives them, in the order of the file."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, fields

import numpy as np

from flight_replay.exceptions import LogError
from flight_replay.geometry.arrays import Flags, Floats, Indices

MOST_POINTS = 2_000_000
"""A day at 20 Hz; what has more is made to fill the memory."""
_NAN = float("nan")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class TrackPoints:
    """Points as columns (n,), SI units and degrees; what the file does not tell is not a number.

    ``utc_s`` is Unix time; ``alt_m`` is above home, or above the ground where home is not known.
    ``track`` and ``segment`` number the tracks and the segments of all tracks, as the file divides them.
    """

    utc_s: Floats
    lat_deg: Floats
    lon_deg: Floats
    amsl_m: Floats
    alt_m: Floats
    heading_deg: Floats
    north_m_s: Floats
    east_m_s: Floats
    track: Indices
    segment: Indices

    def __len__(self) -> int:
        return len(self.lat_deg)

    def select(self, keep: Flags | Indices) -> TrackPoints:
        """The points that a mask or an index array picks, in that order."""
        return TrackPoints(**{each.name: getattr(self, each.name)[keep] for each in fields(self)})


class PointCollector:
    """Collects the points of a file, tracks and segments one after another."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._columns = {each.name: array("d") for each in fields(TrackPoints)}
        self._track = self._segment = 0

    def __len__(self) -> int:
        return len(self._columns["lat_deg"])

    def begin_track(self) -> None:
        """What follows is of another track."""
        self._track += 1
        self._segment += 1

    def begin_segment(self) -> None:
        """What follows is of another segment of the same track."""
        self._segment += 1

    def add(  # noqa: PLR0913
        self,
        lat_deg: float,
        lon_deg: float,
        *,
        utc_s: float = _NAN,
        amsl_m: float = _NAN,
        alt_m: float = _NAN,
        heading_deg: float = _NAN,
        north_m_s: float = _NAN,
        east_m_s: float = _NAN,
    ) -> None:
        """Add a point.

        Args:
            lat_deg: Latitude.
            lon_deg: Longitude.
            utc_s: Unix time.
            amsl_m: Height above mean sea level.
            alt_m: Height above home or the ground.
            heading_deg: Where the nose points, clockwise from north.
            north_m_s: Velocity over ground.
            east_m_s: Likewise.

        Raises:
            LogError: There are too many.
        """
        velocity = north_m_s, east_m_s
        values = utc_s, lat_deg, lon_deg, amsl_m, alt_m, heading_deg, *velocity, self._track, self._segment
        for column, value in zip(self._columns.values(), values, strict=True):
            column.append(value)
        if len(self) > MOST_POINTS:
            raise LogError(f"{self._name} has more than {MOST_POINTS} points; cut it, or name another log")

    def points(self) -> TrackPoints:
        """All points so far."""
        columns = {name: np.array(column) for name, column in self._columns.items()}
        for name in ("track", "segment"):
            columns[name] = columns[name].astype(np.intp)
        return TrackPoints(**columns)
