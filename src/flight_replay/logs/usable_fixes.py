"""The usable fixes of a recording of one vehicle: positions without a place or implausible ones left out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats, Indices
from flight_replay.logs.plausibility import (
    RecordedPositions,
    Rejection,
    find_implausible,
    rejected_by_reason,
)
from flight_replay.logs.track import Track
from flight_replay.writing.counted import counted


@dataclass(frozen=True, slots=True, eq=False)
class UsableFixes:
    """The usable fixes as a track, which may be empty, and how many positions were left out, by reason."""

    track: Track
    without_position: int
    rejected: dict[str, int]

    def why_none(self) -> str:
        """Why a track is empty, for the end of a sentence."""
        return why_no_fix(self.without_position, self.rejected)


def why_no_fix(without_position: int, rejected: Mapping[str, int]) -> str:
    """Why no position is usable: how many were left out, by reason."""
    why = [f"{count} rejected ({reason})" for reason, count in rejected.items()]
    if without_position:
        why.insert(0, counted(without_position, "empty record"))
    return ", ".join(why) or "there is none"


def usable_fixes(positions: Track, lacks_3d_fix: Flags | None = None) -> UsableFixes:
    """Sort out recorded positions by the rules of ``plausibility``.

    Args:
        positions: All recorded positions, in the order of boot and time, some possibly not finite.
        lacks_3d_fix: Which of them (n,) the receiver had no 3D fix for; by default none.
    """
    recorded = RecordedPositions(
        time_s=positions.time_s,
        lat_deg=_or_outside(positions.lat_deg),
        lon_deg=_or_outside(positions.lon_deg),
        speed_m_s_at=partial(_speed_m_s, positions),
        boot=positions.boot,
        lacks_3d_fix=np.zeros(len(positions), np.bool_) if lacks_3d_fix is None else lacks_3d_fix,
    )
    found = find_implausible(recorded)
    empty = int(np.count_nonzero(found == Rejection.EMPTY))
    return UsableFixes(positions.select(found == Rejection.NONE), empty, rejected_by_reason(found))


def _speed_m_s(positions: Track, index: Indices) -> Floats:
    """Length of the velocity at some positions (m,)."""
    ground_m_s = np.hypot(positions.north_m_s[index], positions.east_m_s[index])
    return np.hypot(ground_m_s, positions.up_m_s[index])


def _or_outside(angle_deg: Floats) -> Floats:
    """Angles (n,), those that are not finite as ones that are not on the globe."""
    known = np.isfinite(angle_deg)
    return angle_deg if known.all() else np.where(known, angle_deg, 999.0)
