"""library.py: the face of the package, used as a notebook uses it."""

import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

import flight_replay
from flight_replay import signals
from flight_replay.events import Event, Phase, PhaseStarted, ReturnCommanded
from flight_replay.exceptions import LogError, MissionError
from flight_replay.logs.flights import select
from flight_replay.logs.sample import sample_log
from flight_replay.simulator.dynamics.limits import Limits


def test_a_flight_is_planned_flown_and_drawn() -> None:
    """From a log to a picture, with what the package itself offers."""
    track = select(flight_replay.read_log(sample_log()).track, to_s=60.0)
    route = flight_replay.plan(track, max_points=5)
    replay = flight_replay.replay(route, speedup=20.0)
    assert (replay.record.problem, replay.record.waypoints_reached) == (None, 5)
    position = replay.outcome.errors.path_m.recorded_to_path.statistics
    assert position is not None
    assert position.max < 1.0
    assert flight_replay.errors(track, replay.record.flown).path_m.path_to_recorded.error.mean() < 1.0
    page = flight_replay.figure(route, replay)
    assert len(page.axes) >= 5
    assert flight_replay.figure(route) is not page


@pytest.mark.parametrize("number", signals.TERMINATION_SIGNALS)
def test_a_signal_returns_the_vehicle(number: int) -> None:
    """SIGTERM in a program that flies with the library is RTL too, and its own handlers are back then."""
    before = [signal.getsignal(each) for each in signals.TERMINATION_SIGNALS]
    route = flight_replay.plan(flight_replay.read_log(sample_log()).track, max_points=5)
    seen: list[Event] = []

    def listener(event: Event) -> None:
        seen.append(event)
        if event == PhaseStarted(Phase.MISSION):
            signal.raise_signal(signal.Signals(number))

    with pytest.raises(KeyboardInterrupt):
        flight_replay.replay(route, speedup=20.0, listener=listener)
    assert ReturnCommanded(confirmed=True) in seen
    assert [signal.getsignal(each) for each in signals.TERMINATION_SIGNALS] == before


@pytest.mark.usefixtures("brief_search")
def test_a_whole_flight_can_be_fitted_or_followed() -> None:
    """Both kinds of plan give a route with predicted errors."""
    track = select(flight_replay.read_log(sample_log()).track, from_s=60.0, to_s=110.0)
    fitted = flight_replay.fit(track, max_points=10, speed_m_s="recorded")
    assert fitted.method == "fit"
    followed = flight_replay.plan(track, mode="guided", altitude_m="recorded")
    assert followed.reference is not None
    for route in (fitted, followed):
        assert route.predicted is not None
        assert np.isfinite(route.predicted.position_m.error).all()
    with pytest.raises(MissionError):
        flight_replay.plan(track.select(slice(0, 3)))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"route": "Fit"}, "route must be 'spacing' or 'fit', not 'Fit'"),
        ({"mode": "Guided"}, "mode must be 'auto' or 'guided', not 'Guided'"),
        ({"heading": True}, "heading must be 'vehicle' or 'recorded', not True"),
        ({"speed_m_s": -3.0}, "speed_m_s must be greater than 0, not -3"),
        ({"speed_m_s": 1e3}, "speed_m_s must be 300 or less, not 1000"),
        ({"speed_m_s": "0.5x"}, "speed_m_s must be a number or 'recorded', not '0.5x'"),
        ({"altitude_m": -20.0}, "altitude_m must be greater than 0, not -20"),
        ({"altitude_m": "record"}, "altitude_m must be a number or 'recorded', not 'record'"),
        ({"altitude_m": np.array([20.0])}, "altitude_m must be a number or 'recorded', not a ndarray"),
        ({"altitude_m": None}, "altitude_m must be a number or 'recorded', not None"),
        ({"spacing_m": np.nan}, "spacing_m must be a finite number, not 'nan'"),
        ({"max_points": 0}, "max_points must be a whole number of 1 or more, not '0'"),
        ({"max_points": 7.5}, "max_points must be a whole number of 1 or more, not '7.5'"),
        ({"pace": 0.0, "mode": "guided"}, "pace must be greater than 0, not 0"),
        ({"pace": 0.5}, "pace needs mode='guided'"),
        ({"floor_m": 3.0}, "floor_m is for recorded altitudes and needs altitude_m='recorded'"),
        (
            {"route": "fit", "spacing_m": 5.0},
            "spacing_m is for route='spacing' and cannot be used with route='fit'",
        ),
        (
            {"mode": "guided", "route": "fit"},
            "mode='guided' follows the recording without waypoints; leave out route='fit'",
        ),
        (
            {"mode": "guided", "max_points": 9},
            "max_points is for waypoints and cannot be used with mode='guided'",
        ),
        ({"route": "fit", "max_points": 1}, "route='fit' needs max_points of 2 or more"),
        ({"limits": Limits()}, "limits must be VehicleLimits or None, not Limits"),
    ],
)
def test_a_plan_has_the_arguments_that_options_may_have(arguments: dict[str, Any], message: str) -> None:
    """What the command line refuses is refused, in the words of arguments: nothing else is flown for it."""
    track = flight_replay.read_log(sample_log()).track
    with pytest.raises(MissionError) as refused:
        flight_replay.plan(track, **arguments)
    assert str(refused.value) == message


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda read, _: flight_replay.replay(read), "route must be a Route, such as plan"),
        (
            lambda _, route: flight_replay.replay(route, vehicle=cast(Any, 14550)),
            "vehicle must be a str, such as 'udpin:",
        ),
        (lambda read, _: flight_replay.errors(read.track, read), "flown must be a Track, such as read_log"),
        (lambda read, _: flight_replay.figure(read), "route must be a Route"),
        (
            lambda _, route: flight_replay.figure(route, route),
            "flight must be a FlightResult, such as replay",
        ),
    ],
)
def test_an_argument_of_another_kind_is_refused(call: Callable[[Any, Any], object], message: str) -> None:
    """As where what was read is flown, not what was planned."""
    read = flight_replay.read_log(sample_log())
    with pytest.raises(MissionError) as refused:
        call(read, flight_replay.plan(read.track, max_points=5))
    assert message in str(refused.value)


def test_what_is_no_track_is_refused() -> None:
    """A recording is not one, but has one; a selection may be empty."""
    recording = flight_replay.read_log(sample_log())
    nothing = recording.track.select(slice(0))
    with pytest.raises(MissionError, match=r"a Track, such as read_log\(path\).track, not a Recording"):
        flight_replay.plan(recording)  # type: ignore[arg-type]
    with pytest.raises(MissionError, match="the track has no fix"):
        flight_replay.plan(nothing)
    for pair in ((nothing, recording.track), (recording.track, nothing)):
        with pytest.raises(LogError, match="does not move"):
            flight_replay.errors(*pair)


@pytest.mark.parametrize("arguments", [{"speed_m_s": "recorded"}, {"mode": "guided"}])
def test_what_needs_times_is_refused_without_them(arguments: dict[str, Any]) -> None:
    """A route that was drawn has none."""
    track = replace(flight_replay.read_log(sample_log()).track, timed=False)
    with pytest.raises(MissionError, match="the track has no times: leave out"):
        flight_replay.plan(track, **arguments)


def test_numbers_of_numpy_are_numbers() -> None:
    """Whole ones do for metres, too."""
    track = flight_replay.read_log(sample_log()).track
    route = flight_replay.plan(track, max_points=np.int64(5), altitude_m=20, speed_m_s=np.float32(2.5))
    assert [item.alt_m for _, item in route.mission.waypoints] == [20.0] * 5
    assert route.mission.items[1].params[1] == 2.5


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"yes": "no"}, "yes must be True or False, not 'no'"),
        ({"speedup": 0.0}, "speedup must be greater than 0, not 0"),
        ({"duration_s": -5.0}, "duration_s must be greater than 0, not -5"),
        ({"takeoff_altitude_m": 1e6}, "takeoff_altitude_m must be 80000 or less, not 1e+06"),
    ],
)
def test_a_replay_has_the_arguments_that_options_may_have(arguments: dict[str, Any], message: str) -> None:
    """Nothing is connected to before that."""
    route = flight_replay.plan(flight_replay.read_log(sample_log()).track, max_points=5)
    with pytest.raises(MissionError) as refused:
        flight_replay.replay(route, "/dev/no-such-port", **arguments)
    assert str(refused.value) == message


def test_only_what_is_used_is_imported() -> None:
    """The face costs the command line nothing."""
    code = "import sys, flight_replay; flight_replay.__version__; print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
    with pytest.raises(AttributeError, match="no attribute 'fly'"):
        flight_replay.fly  # noqa: B018
