"""What a person should know of a motion before it is followed: jumps, gaps, and what is not followed."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.movement import turn_deg
from flight_replay.geometry.polyline import segment_lengths_m
from flight_replay.geometry.reference_motion import ReferenceMotion
from flight_replay.planning.following.reference_planner import RecordedMotion
from flight_replay.planning.following.samples import Bridge
from flight_replay.planning.unrecorded_ways import GAP_S, gaps_note

_WORTH_TELLING_M, _WORTH_TELLING_DEG = 1.0, 30.0
_WORTH_SLOWING_M, _WORTH_SLOWING_DEG = 3.0, 90.0
"""A motion that is farther off somewhere may be followed slower."""


def follow_notes(
    motion: RecordedMotion,
    reference: ReferenceMotion,
    bridges: tuple[Bridge, ...],
    *,
    approach_m_s: float,
    pace: float,
) -> tuple[str, ...]:
    """Sentences for people.

    Args:
        motion: what is to be followed.
        reference: what is.
        bridges: the ways of it that were not recorded as flown.
        approach_m_s: the speed of the way to the first fix.
        pace: how many times as fast as recorded the motion is.
    """
    notes = (
        f"The way to the first fix is flown at {approach_m_s:g} m/s.",
        *(_jump_note(motion, bridge) for bridge in bridges),
        _gaps_note(motion, bridges, pace),
        _positions_note(motion, reference, pace),
        _headings_note(motion, reference, pace),
    )
    return tuple(filter(None, notes))


def _jump_note(motion: RecordedMotion, bridge: Bridge) -> str:
    """How low the way is counts: what is there was not flown over."""
    begin = int(np.searchsorted(motion.time_s, bridge.time_s))
    low_m = motion.position_m[begin : begin + 2, 2].min()
    return (
        f"At {bridge.time_s:.0f} s the recording jumps by {bridge.distance_m:.0f} m; "
        f"the vehicle flies there in {bridge.seconds:.0f} s, down to {low_m:.0f} m above home."
    )


def _gaps_note(motion: RecordedMotion, bridges: tuple[Bridge, ...], pace: float) -> str:
    """Where nothing was recorded for long, though the vehicle flew; jumps are told by themselves."""
    jumps = np.isin(motion.time_s[:-1], [bridge.time_s for bridge in bridges])
    gaps = (np.diff(motion.time_s) * pace > GAP_S) & ~jumps
    return gaps_note(gaps, motion.time_s, segment_lengths_m(motion.position_m[:, :2]))


def slower(pace: float) -> str:
    """What to do about a motion that is too fast for the vehicle."""
    return f"follow slower, such as with --speed {pace / 2:g}x"


def _positions_note(motion: RecordedMotion, reference: ReferenceMotion, pace: float) -> str:
    off_m = np.linalg.norm(reference.positions_m(motion.time_s) - motion.position_m, axis=1)
    share, worst = _share_and_worst(off_m, _WORTH_TELLING_M)
    if not share:
        return ""
    next_step = f"; {slower(pace)}" if off_m[worst] > _WORTH_SLOWING_M else ""
    return (
        f"The vehicle's limits do not let it follow {share:.1f} % of the fixes within "
        f"{_WORTH_TELLING_M:.0f} m; the worst is {off_m[worst]:.1f} m off, "
        f"at {motion.time_s[worst]:.0f} s{next_step}."
    )


def _headings_note(motion: RecordedMotion, reference: ReferenceMotion, pace: float) -> str:
    known = np.isfinite(motion.heading_deg)
    headings = reference.headings_deg(motion.time_s[known])
    if headings is None:
        return ""
    off_deg = np.abs(turn_deg(headings[0], motion.heading_deg[known]))
    share, worst = _share_and_worst(off_deg, _WORTH_TELLING_DEG)
    if not share:
        return ""
    next_step = f"; {slower(pace)}" if off_deg[worst] > _WORTH_SLOWING_DEG else ""
    return (
        f"The vehicle does not turn as fast as recorded: {share:.1f} % of the headings are more than "
        f"{_WORTH_TELLING_DEG:.0f} degrees off, the worst {off_deg[worst]:.0f} degrees, "
        f"at {motion.time_s[known][worst]:.0f} s{next_step}."
    )


def _share_and_worst(off: Floats, allowed: float) -> tuple[float, int]:
    """How many percent are farther off than allowed, and which one is farthest off."""
    return 100.0 * float(np.mean(off > allowed)), int(np.argmax(off))
