"""live.py, display.py and status.py: the display says where the replay stands, at any width."""

import errno
import io
import math

import pytest
from rich.console import Console as RichConsole

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
from flight_replay.output.console.display import Display
from flight_replay.output.console.live_console import LiveConsole
from flight_replay.output.replay_status import Status

STATE = VehicleState(81.0, 47.0, 8.0, 29.96, (3.0, 4.0, 0.0), 90.0, "AUTO", True, 12.61, 84.0)
FLIGHT: list[Event] = [
    PhaseStarted(Phase.CONNECT, "tcp:127.0.0.1:5760"),
    PhaseStarted(Phase.UPLOAD, "100"),
    Progress("Uploading", 40, 100, "items"),
    PhaseStarted(Phase.PREARM),
    Waiting(Phase.PREARM, "EKF is not ready"),
    PhaseStarted(Phase.ARM),
    PhaseStarted(Phase.TAKEOFF),
    Climbing(3.0, 28.5, 30.0),
    TargetAltitudeReached(30.0),
    PhaseStarted(Phase.MISSION),
    StatusText(6, "Mission: 22 WP"),
    StatusText(
        4, "Battery 1 is getting low and these words are longer than any narrow terminal is wide, too"
    ),
    WaypointReached(22, 80.5),
    DistanceToWaypoint(23, 3.02, 100),
    STATE,
]


def shown(*events: Event, width: int = 80, encoding: str = "utf-8") -> list[str]:
    """The lines of the display after some events."""
    status = Status()
    for event in events:
        status.update(event)
    stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    console = RichConsole(file=stream, width=width, force_terminal=True, no_color=True, legacy_windows=False)
    with console.capture() as capture:
        console.print(Display(status))
    text = RichConsole(file=io.StringIO(), width=width).render_str(capture.get())
    return [line.rstrip() for line in _plain(str(text)).splitlines()]


def _plain(text: str) -> str:
    from rich.ansi import AnsiDecoder

    return "\n".join(line.plain for line in AnsiDecoder().decode(text))


@pytest.mark.parametrize("width", [20, 40, 80, 120, 200])
def test_no_line_is_wider_than_the_terminal(width: int) -> None:
    """Narrow terminals wrap or shorten; nothing spills."""
    assert all(len(line) <= width for line in shown(*FLIGHT, width=width))


def test_narrow_terminals_break_between_steps_not_within() -> None:
    """A mark stands on the line of its step, a reading on that of its label."""
    steps = shown(*FLIGHT, width=40)[:2]
    assert steps == ["✔ Connect  ✔ Upload  ✔ Prepare  ✔ Arm", "✔ Takeoff  ▶ Mission  · Return  · Close"]
    assert shown(*FLIGHT, width=40)[3:5] == [
        "Altitude 30.0 m  Speed 5.0 m/s",
        "Mode AUTO  Battery 12.6 V 84 %",
    ]


@pytest.mark.parametrize("width", [80, 120])
def test_a_flight_is_told_in_a_few_lines(width: int) -> None:
    """Steps, progress over the waypoints, readings and the autopilot's last words."""
    steps, waypoint, readings, minor, warning = shown(*FLIGHT, width=width)
    assert steps == "✔ Connect  ✔ Upload  ✔ Prepare  ✔ Arm  ✔ Takeoff  ▶ Mission  · Return  · Close"
    assert waypoint.startswith("Waypoint ━")
    assert waypoint.endswith(" 23 of 100, 3.0 m ahead")
    assert readings == "Altitude 30.0 m  Speed 5.0 m/s  Mode AUTO  Battery 12.6 V 84 %"
    assert minor == "Autopilot Mission: 22 WP"
    assert warning.startswith("Autopilot Battery 1 is getting low")


def test_work_under_way_is_a_bar_with_its_amount() -> None:
    """Bytes are told in megabytes, other things by their number; finished work leaves the display."""
    (reading,) = shown(Progress("log", 12_300_000, 272_000_000, "bytes"))
    assert reading.startswith("Log ━")
    assert reading.endswith("12.3 of 272.0 MB")
    (upload,) = shown(Progress("Uploading", 40, 100, "items"))
    assert upload.endswith("40 of 100 items")
    assert shown(Progress("Reading", 5, 5, "bytes")) == []


def test_a_wait_is_shown_with_its_reason_until_the_next_step() -> None:
    """The reason is the vehicle's own."""
    assert shown(*FLIGHT[3:5])[-1] == "Waiting EKF is not ready"
    assert all("Waiting" not in line for line in shown(*FLIGHT[3:6]))


def test_trouble_stays_until_it_is_over() -> None:
    """A lost link and a warning are shown; the link's return clears the line."""
    assert shown(LinkLost(4.2)) == ["Warning nothing heard for 4 s"]
    assert shown(LinkLost(4.2), LinkRestored(5.0)) == []
    assert shown(Notice("the route is long", warning=True), Notice("by the way")) == [
        "Warning the route is long"
    ]


def test_at_the_end_no_step_is_under_way() -> None:
    """Every step that was begun is ticked, and what changed all the time is gone."""
    events: list[Event] = [
        *FLIGHT,
        PhaseStarted(Phase.RETURN),
        ReturnCommanded(True),
        PhaseStarted(Phase.CLOSE),
    ]
    steps, waypoint = shown(*events, Finished("duration"))
    assert steps.count("✔") == 8
    assert waypoint.startswith("Waypoint")


def test_take_off_tells_how_high_it_goes() -> None:
    """While climbing, the altitude stands beside its target; later it stands alone."""
    low = VehicleState(1.0, 47.0, 8.0, 3.21, (0.0, 0.0, 1.0), None, "GUIDED", armed=True)
    assert shown(PhaseStarted(Phase.TAKEOFF), Climbing(3.2, 28.5, 30.0), low)[1].startswith(
        "Altitude 3.2 of 30 m"
    )
    assert shown(Climbing(3.2, 28.5, 30.0), PhaseStarted(Phase.MISSION), low)[1].startswith("Altitude 3.2 m ")


def test_a_terminal_without_unicode_gets_ascii_marks() -> None:
    """An ASCII terminal is not sent what it cannot show."""
    assert shown(PhaseStarted(Phase.CONNECT, "a"), encoding="ascii")[0].startswith("> Connect")


def test_readings_that_are_not_known_are_left_out() -> None:
    """No battery, no distance: no empty labels; and speed is not a number before a position came."""
    bare = VehicleState(1.0, 47.0, 8.0, 0.0, (0.0, 0.0, 0.0), None, "STABILIZE", armed=False)
    (line,) = shown(bare)
    assert "Battery" not in line
    (progress,) = shown(DistanceToWaypoint(1, None, 9))
    assert progress.endswith(" 1 of 9")
    assert math.isnan(Status().speed_m_s)


def test_status_adds_events_up() -> None:
    """What displays ask for is there after the events."""
    status = Status()
    for event in [*FLIGHT, ReturnCommanded(confirmed=True), Finished("duration")]:
        status.update(event)
    assert status.phase is Phase.MISSION
    assert status.reached == [22]
    assert status.target_m == 30.0
    assert (status.rtl_confirmed, status.ended) == (True, "duration")


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def run_live(verbose: bool, events: list[Event]) -> str:
    """Everything a live console writes."""
    stream = Terminal()
    with LiveConsole(stream, verbose=verbose) as console:
        console.say("Generating waypoints from tlog...")
        for event in events:
            console.listener(event)
        with console.paused():
            stream.write("question?")
    return stream.getvalue()


def test_notices_scroll_by_above_the_display() -> None:
    """What we say stays readable; the verbose see everything that the autopilot says too."""
    events: list[Event] = [*FLIGHT, Notice("one thing", warning=True)]
    written = run_live(False, events)
    assert "Generating waypoints from tlog..." in written
    assert "Warning: one thing" in written
    assert "question?" in written
    assert " Autopilot: Mission: 22 WP" not in written
    everything = run_live(True, events)
    assert " Autopilot: Mission: 22 WP" in everything
    assert "Distance to waypoint" not in everything


def test_names_that_are_no_text_can_be_said() -> None:
    """A byte that is no character is spelled out."""
    stream = Terminal()
    with LiveConsole(stream) as console:
        console.say("\udcff.tlog")
        console.listener(Notice("\udcfe.tlog"))
    assert r"\udcff.tlog" in stream.getvalue()
    assert r"\udcfe.tlog" in stream.getvalue()


def test_the_result_stands_below_the_display() -> None:
    """What is said after the end comes after the last drawing of the steps."""
    stream = Terminal()
    with LiveConsole(stream) as console:
        console.listener(PhaseStarted(Phase.CLOSE))
        console.listener(Finished("duration"))
        console.say("Reached 22 of 100 waypoints")
    assert stream.getvalue().rindex("Reached 22") > stream.getvalue().rindex("Close")


def test_no_color_is_honoured_by_the_display(monkeypatch: pytest.MonkeyPatch) -> None:
    """With NO_COLOR no colour code is written."""
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.delenv("NO_COLOR", raising=False)
    assert "\x1b[33m" in run_live(False, [Notice("x", warning=True)])
    monkeypatch.setenv("NO_COLOR", "1")
    assert "\x1b[33m" not in run_live(False, [Notice("x", warning=True)])


def test_a_terminal_that_is_closed_does_not_hide_an_interrupt() -> None:
    """SIGHUP comes with a terminal that takes no more words: the program still was interrupted."""

    class Closed(Terminal):
        closed_now = False

        def write(self, text: str) -> int:
            if self.closed_now:
                raise OSError(errno.EIO, "Input/output error")
            return super().write(text)

    stream = Closed()
    with pytest.raises(KeyboardInterrupt), LiveConsole(stream) as console:
        console.listener(PhaseStarted(Phase.CONNECT))
        stream.closed_now = True
        raise KeyboardInterrupt
