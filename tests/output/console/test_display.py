"""display.py: the live display at any width."""

import io

import pytest
from rich.console import Console as RichConsole

from flight_replay.events import (
    Climbing,
    DistanceToStart,
    DistanceToWaypoint,
    Event,
    Finished,
    Following,
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
from flight_replay.output.replay_status import ReplayStatus

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


def shown(*events: Event, width: int = 80, encoding: str = "utf-8", mode: str = "auto") -> list[str]:
    """The lines of the display after some events."""
    status = ReplayStatus()
    for event in events:
        status.update(event)
    stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    console = RichConsole(file=stream, width=width, force_terminal=True, no_color=True, legacy_windows=False)
    with console.capture() as capture:
        console.print(Display(status, mode))
    text = RichConsole(file=io.StringIO(), width=width).render_str(capture.get())
    return [line.rstrip() for line in _plain(str(text)).splitlines()]


def _plain(text: str) -> str:
    from rich.ansi import AnsiDecoder

    return "\n".join(line.plain for line in AnsiDecoder().decode(text))


@pytest.mark.parametrize("width", [20, 40, 80, 120, 200])
def test_no_line_is_wider_than_the_terminal(width: int) -> None:
    """Lines are wrapped or shortened at any width."""
    assert all(len(line) <= width for line in shown(*FLIGHT, width=width))


def test_narrow_terminals_break_between_phases_only() -> None:
    """A mark is on the line of its phase, a reading on that of its label."""
    phases = shown(*FLIGHT, width=40)[:2]
    assert phases == ["✔ Connect  ✔ Upload  ✔ Prepare  ✔ Arm", "✔ Takeoff  ▶ Mission  · Return  · Close"]
    assert shown(*FLIGHT, width=40)[3:5] == [
        "Altitude 30.0 m  Speed 5.0 m/s",
        "Mode AUTO  Battery 12.6 V 84 %",
    ]


@pytest.mark.parametrize("width", [80, 120])
def test_a_flight_takes_a_few_lines(width: int) -> None:
    """Phases, progress over the waypoints, readings and the autopilot's last texts."""
    phases, waypoint, readings, minor, warning = shown(*FLIGHT, width=width)
    assert phases == "✔ Connect  ✔ Upload  ✔ Prepare  ✔ Arm  ✔ Takeoff  ▶ Mission  · Return  · Close"
    assert waypoint.startswith("Waypoint ━")
    assert waypoint.endswith(" 23 of 100, 3.0 m ahead")
    assert readings == "Altitude 30.0 m  Speed 5.0 m/s  Mode AUTO  Battery 12.6 V 84 %"
    assert minor == "Autopilot Mission: 22 WP"
    assert warning.startswith("Autopilot Battery 1 is getting low")


def test_progress_is_a_bar_with_its_amount() -> None:
    """Bytes are shown in megabytes, other units by number; complete progress is not shown."""
    (reading,) = shown(Progress("log", 12_300_000, 272_000_000, "bytes"))
    assert reading.startswith("Log ━")
    assert reading.endswith("12.3 of 272.0 MB")
    (upload,) = shown(Progress("Uploading", 40, 100, "items"))
    assert upload.endswith("40 of 100 items")
    assert shown(Progress("Reading", 5, 5, "bytes")) == []


def test_a_wait_is_shown_with_its_reason_until_the_next_phase() -> None:
    """The reason is the autopilot's own text."""
    assert shown(*FLIGHT[3:5])[-1] == "Waiting EKF is not ready"
    assert all("Waiting" not in line for line in shown(*FLIGHT[3:6]))


def test_a_warning_is_shown_until_the_link_is_restored() -> None:
    """A lost link is a warning; other notices do not clear one."""
    assert shown(LinkLost(4.2)) == ["Warning link lost"]
    assert shown(LinkLost(4.2), LinkRestored(5.0)) == []
    assert shown(Notice("the route is long", warning=True), Notice("another")) == [
        "Warning the route is long"
    ]


def test_a_finished_replay_has_no_readings() -> None:
    """Every phase is ticked; readings and the distance to the waypoint are gone."""
    events: list[Event] = [
        *FLIGHT,
        PhaseStarted(Phase.RETURN),
        ReturnCommanded(True),
        PhaseStarted(Phase.CLOSE),
    ]
    phases, waypoint = shown(*events, Finished("duration"))
    assert phases.count("✔") == 8
    assert waypoint.endswith(" 23 of 100")


def test_take_off_shows_the_target_altitude() -> None:
    """After take-off the altitude is shown alone."""
    low = VehicleState(1.0, 47.0, 8.0, 3.21, (0.0, 0.0, 1.0), None, "GUIDED", armed=True)
    assert shown(PhaseStarted(Phase.TAKEOFF), Climbing(3.2, 28.5, 30.0), low)[1].startswith(
        "Altitude 3.2 of 30 m"
    )
    assert shown(Climbing(3.2, 28.5, 30.0), PhaseStarted(Phase.MISSION), low)[1].startswith("Altitude 3.2 m ")


def test_an_ascii_terminal_gets_ascii_marks() -> None:
    """Its encoding has no other marks."""
    assert shown(PhaseStarted(Phase.CONNECT, "a"), encoding="ascii")[0].startswith("> Connect")


def test_readings_that_are_not_known_are_left_out() -> None:
    """Without a battery or a distance there is no empty label."""
    bare = VehicleState(1.0, 47.0, 8.0, 0.0, (0.0, 0.0, 0.0), None, "STABILIZE", armed=False)
    (line,) = shown(bare)
    assert "Battery" not in line
    (progress,) = shown(DistanceToWaypoint(1, None, 9))
    assert progress.endswith(" 1 of 9")


def test_following_shows_its_phases_and_how_far_off_it_is() -> None:
    """Instead of those of a mission; a recording that waits says so."""
    phases = (Phase.CONNECT, Phase.PREARM, Phase.ARM, Phase.TAKEOFF, Phase.APPROACH, Phase.FOLLOW)
    begun = [PhaseStarted(phase) for phase in phases]
    assert shown(begun[0], mode="guided") == [
        "▶ Connect  · Prepare  · Arm  · Takeoff  · Approach  · Follow  · Return  · Close"
    ]
    assert shown(*begun[:5], DistanceToStart(12.34), mode="guided")[1] == "Beginning 12.3 m ahead"
    runs_up = shown(
        *begun, DistanceToStart(0.1), Following(1.0, -3.5, 60.0, 0.2, waiting=False), mode="guided"
    )
    assert runs_up[1].endswith("begins in 4 s, 0.20 m off")
    follows = shown(*begun, Following(1.0, 24.0, 60.0, 0.21, waiting=False), mode="guided")
    assert follows[0].startswith("✔ Connect  ✔ Prepare  ✔ Arm  ✔ Takeoff  ✔ Approach  ▶ Follow")
    assert follows[1].startswith("Following ━")
    assert follows[1].endswith("24 of 60 s, 0.21 m off")
    waits = shown(*begun, Following(1.0, 24.0, 60.0, 3.5, waiting=True), mode="guided")
    assert any(line.startswith("Waiting") and "3.50 m off" in line for line in waits)
