"""The usable fixes of a recording of one vehicle: positions without a place or implausible ones left out."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats, Indices
from flight_replay.logs.plausibility import REASONS, RecordedPositions, Rejection, find_implausible
from flight_replay.logs.track import Track


@dataclass(frozen=True, slots=True, eq=False)
class UsableFixes:
    """The usable fixes as a track, which may be empty, and how many positions were left out, by reason."""

    track: Track
    without_position: int
    rejected: dict[str, int]

    def why_none(self) -> str:
        """Why a track is empty, for the end of a sentence."""
        why = [f"{count} rejected ({reason})" for reason, count in self.rejected.items()]
        if self.without_position:
            why.insert(0, f"{self.without_position} records are empty")
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
    counts = np.bincount(found, minlength=len(Rejection))
    rejected = {reason: int(counts[kind]) for kind, reason in REASONS.items() if counts[kind]}
    return UsableFixes(positions.select(found == Rejection.NONE), int(counts[Rejection.EMPTY]), rejected)


def _speed_m_s(positions: Track, index: Indices) -> Floats:
    """Length of the velocity at some positions (m,)."""
    ground_m_s = np.hypot(positions.north_m_s[index], positions.east_m_s[index])
    return np.hypot(ground_m_s, positions.up_m_s[index])


def _or_outside(angle_deg: Floats) -> Floats:
    """Angles (n,), those that are not finite as ones that are not on the globe."""
    known = np.isfinite(angle_deg)
    return angle_deg if known.all() else np.where(known, angle_deg, 999.0)
