"""library.py: the face of the package, used as a notebook uses it."""

import signal
import subprocess
import sys

import numpy as np
import pytest

import flight_replay
from flight_replay import signals
from flight_replay.events import Event, Phase, PhaseStarted, ReturnCommanded
from flight_replay.exceptions import MissionError
from flight_replay.logs.flights import select
from flight_replay.logs.sample import sample_log


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


def test_only_what_is_used_is_imported() -> None:
    """The face costs the command line nothing."""
    code = "import sys, flight_replay; flight_replay.__version__; print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
    with pytest.raises(AttributeError, match="no attribute 'fly'"):
        flight_replay.fly  # noqa: B018
