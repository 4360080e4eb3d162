"""console.py: plain lines, how often they are repeated, and the choice of a live display."""

import io

import pytest

from flight_replay.events import (
    DistanceToWaypoint,
    Event,
    Following,
    Notice,
    Phase,
    PhaseStarted,
    StatusText,
    Waiting,
    WaypointReached,
)
from flight_replay.output.console.console import PlainConsole, open_console
from flight_replay.output.console.live_console import LiveConsole
from tests.helpers.streams import Terminal


class Clock:
    """A clock that is set by hand."""

    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


def lines_of(*events: Event, quiet: bool = False, verbose: bool = False) -> list[str]:
    """What a plain console writes while its clock stands still."""
    stream = io.StringIO()
    console = PlainConsole(stream, quiet=quiet, verbose=verbose, clock=Clock())
    for event in events:
        console.listener(event)
    return stream.getvalue().splitlines()


def test_verbose_shows_details_and_quiet_only_problems() -> None:
    """The autopilot's words are shown as in DroneKit's example; -q leaves warnings and what was asked for."""
    events: list[Event] = [
        StatusText(6, "Mission: 1 WP"),
        WaypointReached(1, 12.34),
        Notice("one thing"),
        Notice("another", warning=True),
        Notice("an address", asked_for=True),
        PhaseStarted(Phase.MISSION),
    ]
    assert lines_of(*events) == [
        ">>> Mission: 1 WP",
        "one thing",
        "Warning: another",
        "an address",
        "Starting mission",
    ]
    assert lines_of(*events, verbose=True)[:2] == [
        ">>> Mission: 1 WP",
        " Reached waypoint (1) at 12.3 s",
    ]
    assert lines_of(*events, quiet=True) == ["Warning: another", "an address"]


def test_a_reading_is_repeated_once_a_second_or_when_it_is_new() -> None:
    """Many events a second give a line a second, as in the example; a new waypoint is shown at once."""
    stream, clock = io.StringIO(), Clock()
    console = PlainConsole(stream, clock=clock)
    for tenth in range(25):
        clock.now_s = 100 + tenth / 10
        console.listener(DistanceToWaypoint(1, 50.0 - tenth, 9))
    console.listener(DistanceToWaypoint(2, 7.0, 9))
    assert stream.getvalue().splitlines() == [
        "Distance to waypoint (1): 50.00",
        "Distance to waypoint (1): 40.00",
        "Distance to waypoint (1): 30.00",
        "Distance to waypoint (2): 7.00",
    ]


def test_a_recording_that_is_followed_in_haste_has_a_line_a_second() -> None:
    """At speedup 20 its seconds pass twenty times as fast; where it begins is shown at once."""
    stream, clock = io.StringIO(), Clock()
    console = PlainConsole(stream, clock=clock)
    for number, recording_s in enumerate([-2.5, -1.5, -0.5, *range(36)]):
        clock.now_s = 100 + number / 20
        console.listener(Following(float(number), recording_s, 60.0, 0.1, waiting=False))
    assert stream.getvalue().splitlines() == [
        " Begins in 3 s, 0.10 m off",
        " 0 of 60 s, 0.10 m off",
        " 20 of 60 s, 0.10 m off",
    ]


def test_a_wait_is_repeated_after_five_seconds_or_when_its_reason_changes() -> None:
    """The same reason every tenth of a second is one line."""
    stream, clock = io.StringIO(), Clock()
    console = PlainConsole(stream, clock=clock)
    for tenth in range(60):
        clock.now_s = 100 + tenth / 10
        console.listener(Waiting(Phase.PREARM, "no GPS fix" if tenth < 52 else "EKF is not ready"))
    assert [line[39:-1] for line in stream.getvalue().splitlines()] == [
        "no GPS fix",
        "no GPS fix",
        "EKF is not ready",
    ]


def test_quiet_prints_no_text() -> None:
    """``print`` writes a line as it is, except with -q."""
    normal, quiet = io.StringIO(), io.StringIO()
    with open_console(normal) as console, console.paused():
        console.print("Generating waypoints from tlog...")
    with open_console(quiet, quiet=True) as console:
        console.print("Generating waypoints from tlog...")
    assert normal.getvalue() == "Generating waypoints from tlog...\n"
    assert quiet.getvalue() == ""


def test_the_display_is_live_on_a_terminal_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """It can be forced or forbidden; -q never has it."""
    monkeypatch.setenv("TERM", "xterm")
    with open_console(Terminal()) as console:
        assert isinstance(console, LiveConsole)
    for stream, quiet, live in (
        (io.StringIO(), False, None),
        (Terminal(), True, None),
        (Terminal(), False, False),
    ):
        with open_console(stream, quiet=quiet, live=live) as console:
            assert isinstance(console, PlainConsole)
