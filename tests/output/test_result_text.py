"""result_text.py: the results as lines for people."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.geometry.error_statistics import ErrorStatistics
from flight_replay.logs.track import Armed
from flight_replay.output.outcome import Coverage
from flight_replay.output.result_text import (
    coverage_lines,
    duration_text,
    flight_lines,
    route_lines,
    statistics_text,
)
from flight_replay.planning.spacing import spaced_route
from tests.helpers.made_replays import made_following, made_replay
from tests.helpers.made_tracks import straight_track


@pytest.mark.parametrize(
    ("seconds", "text"), [(0.0, "0 s"), (59.4, "59 s"), (59.6, "1 min 0 s"), (252.0, "4 min 12 s")]
)
def test_durations_are_minutes_and_seconds(seconds: float, text: str) -> None:
    """Rounded to the second, and never 60 of them."""
    assert duration_text(seconds) == text


def test_fixes_on_the_ground_are_not_covered() -> None:
    """Of a route that begins before arming, those flown count, among those flown."""
    armed = np.full(51, Armed.NO, np.int8)
    armed[20:40] = Armed.YES
    track = replace(straight_track(fixes=51), armed=armed)
    route = spaced_route(track, spacing_m=3.0, max_points=30)
    assert route_lines(route)[0].endswith(", covers 10 of 20 fixes")


def test_a_part_says_how_to_fly_all() -> None:
    """The part, the whole, and the options; nothing to be done where all was flown."""
    part = Coverage(10, 100, 46.2, 635.0, ("--route fit", "--duration all"))
    assert coverage_lines(part, "flight-replay --duration all") == [
        " Flown: the first 46 s of 10 min 35 s of recorded flight",
        " To fly all of it: flight-replay --duration all",
    ]
    assert coverage_lines(part) == coverage_lines(part, "")[:1]
    whole = Coverage(100, 100, 635.0, 635.0, ())
    assert coverage_lines(whole) == [" Flown: all 10 min 35 s of recorded flight"]


def test_without_times_fixes_are_counted() -> None:
    """Of such a recording the seconds mean nothing."""
    part = Coverage(10, 100, 9.0, 99.0, ("--route fit",), timed=False)
    assert coverage_lines(part) == [" Flown: the first 10 of 100 recorded fixes"]
    assert coverage_lines(replace(part, fly_all=())) == [" Flown: all 100 recorded fixes"]


def test_a_flight_that_went_wrong_is_not_told_what_else_to_fly() -> None:
    """Its problem is told instead."""
    route, outcome = made_replay()
    assert any("To fly all" in line for line in flight_lines(route, outcome, "all"))
    failed = replace(outcome, record=replace(outcome.record, problem="the pilot took over", ended="pilot"))
    assert not any("To fly all" in line for line in flight_lines(route, failed, "all"))


def test_numbers_have_their_units() -> None:
    """Metres to the centimetre, degrees to the tenth."""
    error = ErrorStatistics(1.234, 2.0, 123.456)
    assert statistics_text(error) == "mean 1.23 m, p95 2.00 m, max 123.46 m"
    assert statistics_text(error, "deg") == "mean 1.2 deg, p95 2.0 deg, max 123.5 deg"
    assert statistics_text(None) == "nothing to compare"


def test_a_recording_that_is_followed_has_words_of_its_own() -> None:
    """Seconds instead of waypoints; what it waited is told where it did."""
    lines = flight_lines(*made_following())
    assert lines[-2] == " Followed 109.6 s of the recording in 114.9 s of GUIDED"
    assert any(line.startswith(" At equal times: by the recording's clock, ") for line in lines)
    assert not any("waited" in line for line in lines)
    waited = flight_lines(*made_following(waits_at_s=40.0, waits_s=7.0))
    assert waited[-3] == " The recording waited 7.0 s for the vehicle"


def test_what_there_is_one_of_is_told_as_the_only_one() -> None:
    """A person does not say "1 of 1 waypoint"."""
    route, outcome = made_replay()
    mission = replace(route.mission, items=route.mission.items[:1])
    for reached, text in ((1, "the only waypoint"), (0, "0 of 1 waypoints")):
        flown = replace(outcome, record=replace(outcome.record, waypoints_reached=reached))
        lines = flight_lines(replace(route, mission=mission), flown)
        assert f" Reached {text} in 60.0 s of AUTO" in lines
    one = Coverage(1, 1, 0.0, 0.0, (), timed=False)
    assert coverage_lines(one) == [" Flown: the only recorded fix"]
