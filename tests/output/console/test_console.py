"""console.py: events to plain lines in the example's wording, and the choice of a live display."""

import io

import pytest

from flight_replay.events import (
    Climbing,
    DistanceToWaypoint,
    Event,
    Finished,
    LinkLost,
    LinkRestored,
    Notice,
    Phase,
    PhaseStarted,
    Progress,
    ReturnCommanded,
    StatusText,
    TargetAltitudeReached,
    VehicleState,
    Waiting,
    WaypointReached,
)
from flight_replay.output.console.console import PlainConsole, open_console
from flight_replay.output.console.live_console import LiveConsole
from flight_replay.output.console.terminal import is_capable_terminal, write_error


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


class Clock:
    """A clock that is moved by hand."""

    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


def lines_of(*events: Event, quiet: bool = False, verbose: bool = False) -> list[str]:
    """What a plain console writes, its clock standing still."""
    stream = io.StringIO()
    console = PlainConsole(stream, quiet=quiet, verbose=verbose, clock=Clock())
    for event in events:
        console.listener(event)
    return stream.getvalue().splitlines()


def test_a_replay_reads_like_dronekits_example() -> None:
    """Every line of the example has its wording, to the last blank and dot."""
    assert lines_of(
        PhaseStarted(Phase.CONNECT, "tcp:127.0.0.1:5760"),
        PhaseStarted(Phase.UPLOAD, "100"),
        PhaseStarted(Phase.PREARM),
        Waiting(Phase.PREARM, ""),
        PhaseStarted(Phase.ARM),
        PhaseStarted(Phase.TAKEOFF),
        Climbing(1.234, 28.5, 30.0),
        TargetAltitudeReached(30.0),
        PhaseStarted(Phase.MISSION),
        DistanceToWaypoint(1, 3.02, 100),
        PhaseStarted(Phase.RETURN),
        PhaseStarted(Phase.CLOSE),
        Finished("duration"),
    ) == [
        "Connecting to vehicle on: tcp:127.0.0.1:5760",
        "Uploading 100 waypoints to vehicle...",
        "Arm and Takeoff",
        " Waiting for vehicle to initialise...",
        " Waiting for arming...",
        " Taking off!",
        " Altitude: 1.23 < 28.50",
        " Reached target altitude of ~30",
        "Starting mission",
        "Distance to waypoint (1): 3.02",
        "Return to launch",
        "Close vehicle object",
        "Completed...",
    ]


def test_what_the_example_has_no_line_for_is_said_in_one() -> None:
    """Waits have their reason, warnings the word, and a bare upload no number."""
    assert lines_of(
        PhaseStarted(Phase.UPLOAD),
        Waiting(Phase.PREARM, "EKF is not ready"),
        Waiting(Phase.CONNECT, "no heartbeat"),
        DistanceToWaypoint(2, None, 3),
        Notice("the built-in copter flies"),
        Notice("the route is long", warning=True),
        LinkLost(4.0),
        LinkRestored(6.25),
        ReturnCommanded(confirmed=True),
        ReturnCommanded(confirmed=False),
        StatusText(4, "PreArm: Compass not calibrated"),
    ) == [
        "Uploading the mission to vehicle...",
        " Waiting for vehicle to initialise... (EKF is not ready)",
        " Waiting (connect)... (no heartbeat)",
        "Distance to waypoint (2): unknown",
        "the built-in copter flies",
        "Warning: the route is long",
        "Warning: nothing heard from the vehicle for 4.0 s",
        " The vehicle is heard again after 6.2 s",
        " The vehicle confirmed RTL",
        "Warning: the vehicle has not confirmed RTL",
        " Autopilot: PreArm: Compass not calibrated",
    ]


STATE = VehicleState(1.0, 47.0, 8.0, 30.0, (1.0, 0.0, 0.0), 90.0, "AUTO", armed=True)
QUIET_ONES: list[Event] = [Progress("Reading", 1, 2, "bytes"), STATE]


@pytest.mark.parametrize("event", QUIET_ONES)
def test_positions_and_progress_have_no_line(event: Event) -> None:
    """They drive the displays."""
    assert lines_of(event, verbose=True) == []


def test_details_are_for_the_verbose_and_trouble_for_the_quiet() -> None:
    """Minor words of the autopilot need -v; -q leaves only what went wrong."""
    events: list[Event] = [
        StatusText(6, "Mission: 1 WP"),
        WaypointReached(1, 12.34),
        Notice("one thing"),
        Notice("another", warning=True),
        PhaseStarted(Phase.MISSION),
    ]
    assert lines_of(*events) == ["one thing", "Warning: another", "Starting mission"]
    assert lines_of(*events, verbose=True)[:2] == [
        " Autopilot: Mission: 1 WP",
        " Reached waypoint (1) at 12.3 s",
    ]
    assert lines_of(*events, quiet=True) == ["Warning: another"]


def test_a_reading_is_repeated_once_a_second_or_when_it_is_another() -> None:
    """However fast events come, the lines come at the example's pace; a new waypoint comes at once."""
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


def test_a_wait_is_said_again_when_its_reason_changes_or_after_five_seconds() -> None:
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


def test_our_own_words_are_not_for_the_quiet() -> None:
    """``say`` writes lines as they are, and needs no pause for a question."""
    loud, quiet = io.StringIO(), io.StringIO()
    with open_console(loud) as console, console.paused():
        console.say("Generating waypoints from tlog...")
    with open_console(quiet, quiet=True) as console:
        console.say("Generating waypoints from tlog...")
    assert loud.getvalue() == "Generating waypoints from tlog...\n"
    assert quiet.getvalue() == ""


def test_a_live_display_needs_a_terminal_that_can_move_its_cursor() -> None:
    """Files, pipes and TERM=dumb get plain lines."""
    assert is_capable_terminal(Terminal(), {"TERM": "xterm"})
    assert not is_capable_terminal(Terminal(), {"TERM": "dumb"})
    assert not is_capable_terminal(io.StringIO(), {"TERM": "xterm"})


def test_the_display_is_live_on_a_terminal_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """It can be forced or forbidden; the quiet never get it."""
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


@pytest.mark.parametrize(
    ("stream", "environment", "coloured"),
    [
        (Terminal(), {"TERM": "xterm"}, True),
        (Terminal(), {"TERM": "xterm", "NO_COLOR": "1"}, False),
        (Terminal(), {"TERM": "dumb"}, False),
        (io.StringIO(), {"TERM": "xterm"}, False),
    ],
    ids=["terminal", "no-color", "dumb", "file"],
)
def test_errors_are_in_colour_on_a_terminal_only(
    stream: io.StringIO, environment: dict[str, str], coloured: bool
) -> None:
    """NO_COLOR and TERM=dumb are honoured; the words stay the same."""
    write_error(stream, "cannot read a.tlog", environment)
    written = stream.getvalue()
    assert ("\x1b[" in written) is coloured
    assert written.replace("\x1b[1;31m", "").replace("\x1b[0m", "") == (
        "flight-replay: error: cannot read a.tlog\n"
    )


def test_characters_that_a_stream_lacks_are_spelled_out() -> None:
    """A file name that is no text, or a terminal without umlauts, is no reason to fail."""
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding="ascii")
    PlainConsole(stream).say("Grüße an \udcff.tlog")
    assert raw.getvalue() == rb"Gr\xfc\xdfe an \udcff.tlog" + b"\n"


def test_an_error_is_one_line_whatever_the_file_is_called() -> None:
    """Names may hold newlines and what would set a terminal's colours."""
    stream = io.StringIO()
    write_error(stream, "cannot read two\nlines\x1b[31m ü.tlog")
    assert stream.getvalue() == "flight-replay: error: cannot read two\\nlines\\x1b[31m ü.tlog\n"


class Gone(io.StringIO):
    """A pipe whose reader has left."""

    def write(self, text: str) -> int:
        raise BrokenPipeError


def test_a_reader_that_leaves_does_not_end_the_flight() -> None:
    """``flight-replay | head`` flies on in silence."""
    PlainConsole(Gone()).listener(PhaseStarted(Phase.MISSION))
    write_error(Gone(), "lost")
