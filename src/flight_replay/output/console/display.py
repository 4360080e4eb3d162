"""The live display: the phases of the replay, progress, and the vehicle's readings."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console as RichConsole
from rich.console import ConsoleOptions, Group, RenderableType, RenderResult
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from flight_replay.events import DistanceToWaypoint, Following, Phase, Progress, Severity, VehicleState
from flight_replay.output.replay_status import ReplayStatus, battery_text, following_text

_PHASE_NAMES = {
    Phase.CONNECT: "Connect",
    Phase.UPLOAD: "Upload",
    Phase.PREARM: "Prepare",
    Phase.ARM: "Arm",
    Phase.TAKEOFF: "Takeoff",
    Phase.MISSION: "Mission",
    Phase.APPROACH: "Approach",
    Phase.FOLLOW: "Follow",
    Phase.RETURN: "Return",
    Phase.CLOSE: "Close",
}
_LEFT_OUT = {"auto": {Phase.APPROACH, Phase.FOLLOW}, "guided": {Phase.UPLOAD, Phase.MISSION}}
_MARKS = {"done": "✔", "now": "▶", "ahead": "·"}
_ASCII_MARKS = {"done": "+", "now": ">", "ahead": "-"}
_MARK_STYLES = {"done": "green", "now": "bold cyan", "ahead": "dim"}
_GAP = "  "
_BYTES_PER_MB = 1_000_000


class Display:
    """Renders a status at the width of the terminal; nothing before the first event.

    ``mode`` is the way of flying, "auto" or "guided".
    """

    def __init__(self, status: ReplayStatus, mode: str = "auto") -> None:
        self._status = status
        self._phases = [phase for phase in _PHASE_NAMES if phase not in _LEFT_OUT[mode]]

    def __rich_console__(self, console: RichConsole, options: ConsoleOptions) -> RenderResult:
        """The lines that have something to show."""
        status = self._status
        parts: list[RenderableType] = []
        if status.started:
            marks = _ASCII_MARKS if options.ascii_only else _MARKS
            parts += _rows(_phases(status, self._phases, marks), options.max_width)
        if status.progress is not None:
            parts.append(_progress(status.progress))
        if status.current_waypoint is not None:
            parts.append(_waypoint(status.current_waypoint, flying=status.ended is None))
        if status.following is not None:
            parts.append(_following(status.following))
        elif status.to_start_m is not None and status.ended is None:
            parts.append(_line("Beginning", f"{status.to_start_m:.1f} m ahead", ""))
        if status.ended is None:
            parts += _readings(status, options.max_width)
        if status.warning:
            parts.append(_line("Warning", status.warning, "bold yellow"))
        yield Group(*parts)


def _readings(status: ReplayStatus, width: int) -> list[RenderableType]:
    """The readings of a replay that is under way."""
    parts: list[RenderableType] = []
    if status.waiting:
        parts.append(_line("Waiting", status.waiting, "yellow"))
    if status.vehicle is not None:
        parts += _rows(_vehicle(status, status.vehicle), width)
    for status_text in status.status_texts:
        style = "yellow" if status_text.severity <= Severity.WARNING else "dim"
        parts.append(_line("Autopilot", status_text.text, style))
    return parts


def _phases(status: ReplayStatus, phases: Sequence[Phase], marks: dict[str, str]) -> list[Text]:
    shown = []
    for phase in phases:
        state = "ahead" if phase not in status.started else "done"
        if phase is status.phase and status.ended is None:
            state = "now"
        shown.append(Text(f"{marks[state]} {_PHASE_NAMES[phase]}", style=_MARK_STYLES[state]))
    return shown


def _rows(pieces: list[Text], width: int) -> list[Text]:
    """The pieces side by side in as few rows as the width allows; no piece is broken."""
    rows: list[Text] = []
    for piece in pieces:
        if rows and len(rows[-1]) + len(_GAP) + len(piece) <= width:
            rows[-1] = Text.assemble(rows[-1], _GAP, piece)
        else:
            rows.append(piece)
    return rows


def _progress(progress: Progress) -> RenderableType:
    done, total, unit = progress.done, progress.total, progress.unit
    if unit == "bytes":
        amount = f"{done / _BYTES_PER_MB:.1f} of {total / _BYTES_PER_MB:.1f} MB"
    else:
        amount = f"{done} of {total} {unit}".rstrip()
    return _bar(progress.what[:1].upper() + progress.what[1:], amount, done, total)


def _waypoint(waypoint: DistanceToWaypoint, *, flying: bool) -> RenderableType:
    amount = f"{waypoint.number} of {waypoint.waypoints}"
    if flying and waypoint.distance_m is not None:
        amount += f", {waypoint.distance_m:.1f} m ahead"
    return _bar("Waypoint", amount, waypoint.number, waypoint.waypoints)


def _following(following: Following) -> RenderableType:
    done_s, of_s = max(following.recording_s, 0.0), following.of_s
    amount = f"{following_text(following)}, {following.error_m:.2f} m off"
    return _bar("Waiting" if following.waiting else "Following", amount, round(done_s), round(of_s))


def _bar(label: str, amount: str, done: int, total: int) -> RenderableType:
    row = Table.grid(padding=(0, 1), expand=True)
    row.add_column(no_wrap=True, overflow="ellipsis", max_width=24)
    row.add_column(ratio=1)
    row.add_column(no_wrap=True, justify="right")
    bar = ProgressBar(total=max(total, 1), completed=done, complete_style="cyan", finished_style="green")
    row.add_row(Text(label), bar, Text(amount))  # Of a plain text, rich would take [words] for markup.
    return row


def _vehicle(status: ReplayStatus, vehicle: VehicleState) -> list[Text]:
    altitude = f"{vehicle.alt_m:.1f}"
    if status.phase is Phase.TAKEOFF and status.target_altitude_m is not None:
        altitude += f" of {status.target_altitude_m:g}"
    values = {
        "Altitude": f"{altitude} m",
        "Speed": f"{status.speed_m_s:.1f} m/s",
        "Mode": status.mode,
        "Battery": battery_text(vehicle),
    }
    return [Text.assemble((label, "dim"), " ", value) for label, value in values.items() if value]


def _line(label: str, text: str, style: str) -> Text:
    line = Text.assemble((label, "dim"), " ", (text, style))
    line.no_wrap, line.overflow = True, "ellipsis"
    return line
