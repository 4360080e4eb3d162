"""What a route does with heights, in numbers and words."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.planning.altitude import RECORDED
from flight_replay.planning.heights import RouteHeights, heights_of
from flight_replay.planning.route_heights import route_heights
from flight_replay.planning.spacing import spaced_route
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.made_tracks import straight_track


def heights(
    altitudes_m: float | list[float], *, takeoff_m: float = 30.0, floor_m: float = 5.0, timed: bool = False
) -> RouteHeights:
    """Those of a route that flies 51 recorded altitudes."""
    track = straight_track(altitudes_m=altitudes_m)
    track = replace(track, amsl_m=track.alt_m + 400.0)
    route = spaced_route(track, altitude_m=RECORDED, floor_m=floor_m)
    if timed:
        planned_m = heights_of(track, RECORDED, floor_m, Limits()).planned_m
        route = replace(route, planned_up_m=planned_m[: len(route.wanted)])
    return route_heights(route, takeoff_m=takeoff_m, floor_m=floor_m)


def test_a_level_route_has_nothing_to_say() -> None:
    """Taken off to the altitude of its first waypoint; AUTO takes over at the end of the climb."""
    level = heights(30.0)
    assert (level.raised.fixes, level.limited.fixes, level.notes) == (0, 0, ())
    assert 0.0 < level.climb_s < 1.0


@pytest.mark.parametrize(
    ("takeoff_m", "text", "at_least_s"), [(30.0, "descends 10.0 m", 6.6), (15.0, "climbs 5.0 m", 2.0)]
)
def test_the_climb_to_the_first_waypoint_is_said(takeoff_m: float, text: str, at_least_s: float) -> None:
    """With its time, which AUTO takes longer."""
    climbing = heights(20.0, takeoff_m=takeoff_m)
    (note,) = climbing.notes
    assert text in note
    assert "at 20.0 m" in note
    assert at_least_s < climbing.climb_s < at_least_s + 4.0


@pytest.mark.parametrize(("first_m", "climb_s"), [(5.0, 18.6), (30.0, 0.5), (60.0, 13.6)])
def test_the_climb_takes_as_long_as_in_a_whole_flight(first_m: float, climb_s: float) -> None:
    """From the take-off altitude of 30 m, up and down, within a second."""
    flight = heights(first_m)
    assert flight.climb_s == pytest.approx(climb_s, abs=1.0)


def test_a_climb_out_of_sight_is_not_simulated() -> None:
    """Its time is that of the climb rate."""
    assert heights(8000.0).climb_s == pytest.approx((8000.0 - 30.0) / 2.5)


def test_fixes_below_the_floor_are_counted() -> None:
    """How many, and how far below it they were recorded."""
    low = heights([2.0] * 10 + [4.5] * 5 + [30.0] * 36, takeoff_m=5.0)
    assert (low.raised.fixes, low.raised.max_m) == (15, 3.0)
    (note,) = low.notes
    assert (
        note == "Below the floor of 5 m, by up to 3.0 m: 15 of 51 flown fixes; flown at the floor (--floor)."
    )


def test_of_a_flight_down_a_cliff_is_said_how_its_heights_are_kept() -> None:
    """So much higher that the lowest is at the floor, which is not said once it is asked for."""
    track = straight_track(altitudes_m=[-38.7] * 30 + [6.0] * 21)
    for raise_m, said_m in ((0.0, 44), (10.0, 44), (44.0, None)):
        route = spaced_route(track, altitude_m=RECORDED, raise_m=raise_m)
        notes = route_heights(route, takeoff_m=5.0, floor_m=5.0, raise_m=raise_m).notes
        said = [note for note in notes if note.endswith(f"add --altitude recorded+{said_m}.")]
        assert len(said) == (said_m is not None)


def test_of_a_flight_that_is_all_below_the_floor_is_said_how_its_heights_are_kept() -> None:
    """As of a track that begins in the air, where home is not known."""
    (note,) = heights([0.0] * 10 + [3.0] * 41, takeoff_m=5.0).notes
    assert note.endswith(" (--floor). To keep differences in height, add --altitude recorded+5.")


def test_raised_heights_have_their_floor() -> None:
    """What is below it even so is counted, by what it would be flown at."""
    track = straight_track(altitudes_m=[-8.0] * 10 + [2.0] * 41)
    route = spaced_route(track, altitude_m=RECORDED, raise_m=10.0)
    raised = route_heights(route, takeoff_m=5.0, floor_m=5.0, raise_m=10.0)
    assert (raised.raised.fixes, raised.raised.max_m) == (10, 3.0)
    (note,) = raised.notes
    assert note.startswith(
        "Below the floor of 5 m, by up to 3.0 m: 10 of 51 flown fixes, 10 m higher than recorded; "
    )
    assert set(route.recorded.alt_m) == {-8.0, 2.0}


def test_heights_that_cannot_be_kept_are_said() -> None:
    """Where, by how much, and to which side: sooner up is too high, later up too low."""
    limited = heights([10.0] * 25 + [40.0] * 26, takeoff_m=10.0, timed=True)
    assert limited.limited.max_m > 10.0
    assert 8 <= limited.limited.fixes <= 32
    (note,) = limited.notes
    assert "begins sooner and ends later" in note
    assert f"{limited.limited.max_m:.1f} m too high from 17 to 24 s, " in note
    assert note.endswith(" m too low from 25 to 32 s.")


def test_a_constant_altitude_has_no_floor() -> None:
    """Nothing is raised, whatever was recorded."""
    route = spaced_route(straight_track(altitudes_m=1.0), altitude_m=30.0)
    constant = route_heights(route, takeoff_m=30.0, floor_m=None)
    assert (constant.floor_m, constant.raised.fixes, constant.notes) == (None, 0, ())


def test_unknown_heights_are_not_counted() -> None:
    """Where the recording has no height it is flown at that of the next fix, and was not below the floor."""
    track = replace(straight_track(), alt_m=np.append(np.full(20, np.nan), np.full(31, 12.0)))
    route = spaced_route(track, altitude_m="recorded")
    assert route_heights(route, takeoff_m=5.0, floor_m=5.0).raised.fixes == 0
