"""What is said of a motion before it is followed."""

from __future__ import annotations

import numpy as np
import pytest

from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.planning.drag import sitl_drag
from flight_replay.planning.following.follow_notes import follow_notes
from flight_replay.planning.following.reference_planner import RecordedMotion, ReferenceBounds, plan_reference
from flight_replay.planning.following.samples import Bridge
from flight_replay.simulator.dynamics.limits import Limits


def _notes(
    times_s: np.ndarray,
    heading_deg: np.ndarray | None = None,
    bridges: tuple[Bridge, ...] = (),
    pace: float = 1.0,
) -> tuple[str, ...]:
    """The notes of a straight flight at 2 m/s, but that of the way to its beginning."""
    places = np.column_stack([2.0 * times_s, 0.0 * times_s, 0.0 * times_s + 20.0])
    headings = np.full(len(times_s), np.nan) if heading_deg is None else heading_deg
    motion = RecordedMotion(FlatFrame(47.0, 8.0), times_s, places, headings)
    bounds = ReferenceBounds.of(Limits())
    reference = plan_reference(motion, bounds, sitl_drag(400.0), headings=True, floor_m=5.0)
    notes = follow_notes(motion, reference, bridges, approach_m_s=10.0, pace=pace)
    assert notes[0] == "The way to the first fix is flown at 10 m/s."
    return notes[1:]


def _with_gaps(*lengths_s: float) -> np.ndarray:
    """A fix a second, five between gaps."""
    steps_s = [[1.0] * 5 + [length_s] for length_s in lengths_s]
    return np.concatenate([[0.0], np.cumsum(np.concatenate([*steps_s, [1.0] * 5]))])


def test_of_a_motion_that_can_be_followed_nothing_else_is_said() -> None:
    times_s = np.arange(0.0, 20.0, 0.5)
    assert _notes(times_s, 40.0 * times_s % 360.0) == ()


def test_gaps_are_said() -> None:
    assert _notes(_with_gaps(20.0, 4.0)) == (
        "The vehicle flies straight on where nothing is recorded: 20 s from 5 s on (40 m).",
    )


def test_the_longest_gaps_are_said_in_their_order() -> None:
    (note,) = _notes(_with_gaps(30.0, 6.0, 8.0, 20.0, 7.0))
    assert note.endswith(
        "30 s from 5 s on (60 m), 8 s from 51 s on (16 m), 20 s from 64 s on (40 m), 2 times more."
    )


@pytest.mark.parametrize(("pace", "said"), [(0.1, False), (1.0, True)])
def test_fixes_are_not_farther_apart_when_they_are_followed_slowly(pace: float, said: bool) -> None:
    assert bool(_notes(_with_gaps(10.0), pace=pace)) is said


def test_a_jump_is_no_gap() -> None:
    notes = _notes(_with_gaps(20.0), bridges=(Bridge(5.0, 40.0, 20.0),))
    assert notes == (
        "At 5 s the recording jumps by 40 m; the vehicle flies there in 20 s, down to 20 m above home.",
    )


def test_a_vehicle_that_turns_more_slowly_is_said() -> None:
    times_s = np.arange(0.0, 30.0, 0.25)
    spins_deg = np.where(times_s < 10.0, 0.0, 150.0 * (times_s - 10.0)) % 360.0
    (note,) = _notes(times_s, spins_deg, pace=0.5)
    assert note.startswith("The vehicle does not turn as fast as recorded: ")
    assert "% of the headings are more than 30 degrees off, the worst 1" in note
    assert note.endswith(" s; follow slower, such as with --speed 0.25x.")


def test_for_a_turn_that_comes_a_little_late_nothing_is_slowed_down() -> None:
    """70 degrees at twice the vehicle's rate."""
    times_s = np.arange(0.0, 30.0, 0.25)
    (note,) = _notes(times_s, np.clip(120.0 * (times_s - 10.0), 0.0, 140.0))
    assert note.startswith("The vehicle does not turn as fast as recorded: ")
    assert "slower" not in note
