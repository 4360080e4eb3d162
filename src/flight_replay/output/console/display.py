"""What the live display shows: the steps of the replay, what is under way, and the vehicle's readings."""

from __future__ import annotations

import math

from rich.console import Console as RichConsole
from rich.console import ConsoleOptions, Group, RenderableType, RenderResult
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from flight_replay.events import DistanceToWaypoint, Phase, Progress, VehicleState
from flight_replay.output.event_text import WARNING_SEVERITY
from flight_replay.output.replay_status import Status

_STEPS = {
    Phase.CONNECT: "Connect",
    Phase.UPLOAD: "Upload",
    Phase.PREARM: "Prepare",
    Phase.ARM: "Arm",
    Phase.TAKEOFF: "Takeoff",
    Phase.MISSION: "Mission",
    Phase.RETURN: "Return",
    Phase.CLOSE: "Close",
}
_MARKS = {"done": "✔", "now": "▶", "ahead": "·"}
_ASCII_MARKS = {"done": "+", "now": ">", "ahead": "-"}
_MARK_STYLES = {"done": "green", "now": "bold cyan", "ahead": "dim"}
_GAP = "  "
_BYTES_PER_MB = 1_000_000


class Display:
    """The display at one moment; an empty one before anything has happened."""

    def __init__(self, status: Status) -> None:
        self._status = status

    def __rich_console__(self, console: RichConsole, options: ConsoleOptions) -> RenderResult:
        """The lines that there is something to say in, as wide as the terminal is."""
        status = self._status
        parts: list[RenderableType] = []
        if status.begun:
            marks = _ASCII_MARKS if options.ascii_only else _MARKS
            parts += _rows(_steps(status, marks), options.max_width)
        if status.progress is not None:
            parts.append(_work(status.progress))
        if status.heading is not None:
            parts.append(_waypoints(status.heading))
        if status.ended is None:
            parts += _under_way(status, options.max_width)
        if status.trouble:
            parts.append(_line("Warning", status.trouble, "bold yellow"))
        yield Group(*parts)


def _under_way(status: Status, width: int) -> list[RenderableType]:
    """What changes all the time, and says nothing any more once the replay is over."""
    parts: list[RenderableType] = []
    if status.waiting:
        parts.append(_line("Waiting", status.waiting, "yellow"))
    if status.vehicle is not None:
        parts += _rows(_readings(status, status.vehicle), width)
    for words in status.words:
        style = "yellow" if words.severity <= WARNING_SEVERITY else "dim"
        parts.append(_line("Autopilot", words.text, style))
    return parts


def _steps(status: Status, marks: dict[str, str]) -> list[Text]:
    steps = []
    for phase, name in _STEPS.items():
        state = "ahead" if phase not in status.begun else "done"
        if phase is status.phase and status.ended is None:
            state = "now"
        steps.append(Text(f"{marks[state]} {name}", style=_MARK_STYLES[state]))
    return steps


def _rows(pieces: list[Text], width: int) -> list[Text]:
    """The pieces side by side in as few rows as the width allows, none of them broken."""
    rows: list[Text] = []
    for piece in pieces:
        if rows and len(rows[-1]) + len(_GAP) + len(piece) <= width:
            rows[-1] = Text.assemble(rows[-1], _GAP, piece)
        else:
            rows.append(piece)
    return rows


def _work(progress: Progress) -> RenderableType:
    done, total, unit = progress.done, progress.total, progress.unit
    if unit == "bytes":
        amount = f"{done / _BYTES_PER_MB:.1f} of {total / _BYTES_PER_MB:.1f} MB"
    else:
        amount = f"{done} of {total} {unit}".rstrip()
    return _bar(progress.what[:1].upper() + progress.what[1:], amount, done, total)


def _bar(label: str, amount: str, done: int, total: int) -> RenderableType:
    row = Table.grid(padding=(0, 1), expand=True)
    row.add_column(no_wrap=True, overflow="ellipsis", max_width=24)
    row.add_column(ratio=1)
    row.add_column(no_wrap=True, justify="right")
    bar = ProgressBar(total=max(total, 1), completed=done, complete_style="cyan", finished_style="green")
    row.add_row(label, bar, amount)
    return row


def _waypoints(heading: DistanceToWaypoint) -> RenderableType:
    ahead = "" if heading.distance_m is None else f", {heading.distance_m:.1f} m ahead"
    return _bar("Waypoint", f"{heading.seq} of {heading.last_seq}{ahead}", heading.seq, heading.last_seq)


def _readings(status: Status, vehicle: VehicleState) -> list[Text]:
    climbing = status.phase is Phase.TAKEOFF and status.target_m is not None
    pairs = {
        "Altitude": f"{vehicle.alt_m:.1f} of {status.target_m:g} m" if climbing else f"{vehicle.alt_m:.1f} m",
        "Speed": f"{status.speed_m_s:.1f} m/s",
        "Mode": vehicle.mode,
        "Battery": _battery(vehicle.battery_v, vehicle.battery_percent),
    }
    return [Text.assemble((label, "dim"), " ", value) for label, value in pairs.items() if value]


def _battery(volts: float | None, percent: float | None) -> str:
    parts = [f"{volts:.1f} V" if volts is not None and math.isfinite(volts) else ""]
    parts.append(f"{percent:.0f} %" if percent is not None and math.isfinite(percent) else "")
    return " ".join(filter(None, parts))


def _line(label: str, text: str, style: str) -> Text:
    line = Text.assemble((label, "dim"), " ", (text, style))
    line.no_wrap, line.overflow = True, "ellipsis"
    return line
