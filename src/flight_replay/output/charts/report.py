"""The report: one self-contained HTML file with results, zoomable charts, mission, events and command."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

from flight_replay.mission.formats.item_text import description
from flight_replay.mission.items import FIRST_SEQ, Command, MissionItem
from flight_replay.output.charts.series import FLOWN_COLOUR, ReplaySeries, flown_start_s, replay_series
from flight_replay.output.event_log import LoggedEvent
from flight_replay.output.outcome import Outcome
from flight_replay.planning.route import Route
from flight_replay.supervisor.flight_plan import FlightRecord
from flight_replay.writing.output_files import check_suffix, write_atomically

if TYPE_CHECKING:
    from bokeh.model import Model

SUFFIXES = (".html", ".htm")
Summary = Mapping[str, Any]
_SUMMARIES = {
    None: "Plan only: nothing was flown.",
    "duration": "Flown for the requested duration.",
    "final waypoint": "Flown until the vehicle headed for the final waypoint.",
    "mission complete": "The whole mission was flown.",
}


@dataclass(frozen=True, slots=True)
class ReportText:
    """The text of a report.

    ``summary`` is the ``--json`` object, ``events`` are the entries of an ``EventLog``, ``argv`` the
    arguments of this run without the program's name.
    """

    summary: Summary
    events: Sequence[LoggedEvent] = ()
    argv: Sequence[str] = ()


def save_report(
    path: Path | str,
    text: ReportText,
    route: Route,
    record: FlightRecord | None = None,
    outcome: Outcome | None = None,
) -> None:
    """Write the report of a plan, and of the flight that followed it if there was one.

    Raises:
        FlightReplayError: The suffix is not in ``SUFFIXES``, or the file cannot be written.
    """
    check_suffix(path, SUFFIXES)
    from bokeh.embed import file_html
    from bokeh.resources import Resources
    from jinja2 import Template

    template = files("flight_replay.output.charts").joinpath("report.html").read_text(encoding="utf-8")
    page = file_html(
        _charts(replay_series(route, record, outcome)),
        resources=Resources(mode="inline"),
        title=f"Replay of {PurePath(str(text.summary['log']['path'])).name}",
        template=Template(template),
        template_variables={
            "lead": _lead(record),
            "tables": _tables(text.summary, record),
            "mission": _mission_rows(route, record),
            "events": text.events,
            "command": shlex.join(["flight-replay", *text.argv]),
            "made_by": f"Made by flight-replay {version('flight-replay')}.",
        },
    )
    write_atomically(path, page)


def _lead(record: FlightRecord | None) -> str:
    ended = record.ended if record is not None else None
    return _SUMMARIES.get(ended, f"The flight did not end as planned: {ended}.")


def _charts(series: ReplaySeries) -> list[Model]:
    """The charts that the template shows: one named "paths", and a column named "over_time"."""
    from bokeh.layouts import column

    from flight_replay.output.charts.bokeh_charts import map_chart

    paths = map_chart(series, height=560)
    paths.name = "paths"
    if series.flown is not None:
        north_m, east_m = series.flown.north_east_m.T
        paths.line(east_m, north_m, color=FLOWN_COLOUR, width=1.8, legend_label="flown")
    return [paths, column(*_time_charts(series), sizing_mode="stretch_width", name="over_time")]


def _time_charts(series: ReplaySeries) -> list[Model]:
    """Errors, altitude and speed over one time axis."""
    from flight_replay.output.charts.bokeh_charts import add_line, time_chart

    path_error = time_chart("path error of the recorded fixes", "error (m)")
    charts = [path_error]
    add_line(path_error, series.planned_error.time_s, series.planned_error.error_m, "planned")
    if series.path_error is not None:
        add_line(path_error, series.path_error.time_s, series.path_error.error_m, "flown")
    if series.position_error is not None:
        position_error = time_chart("position error at equal times", "error (m)", x_range=path_error.x_range)
        add_line(position_error, series.position_error.time_s, series.position_error.error_m, "flown")
        charts.append(position_error)
    altitude = time_chart("altitude above home", "altitude (m)", x_range=path_error.x_range)
    speed = time_chart("ground speed", "speed (m/s)", x_range=path_error.x_range)
    for name, track in (("recorded", series.recorded), ("flown", series.flown)):
        if track is not None:
            add_line(altitude, track.time_s, track.alt_m, name)
            add_line(speed, track.time_s, track.speed_m_s, name)
    return [*charts, altitude, speed]


def _tables(summary: Summary, record: FlightRecord | None) -> dict[str, list[tuple[str, str]]]:
    """Rows of (label, value) by heading."""
    tables = {"Log": _log_rows(summary["log"]), "Route": _route_rows(summary["route"])}
    flight = summary.get("flight")
    if flight is not None:
        tables["Flight"] = [
            ("vehicle", str(flight["vehicle"])),
            ("waypoints reached", f"{flight['waypoints_reached']} of {summary['route']['points']}"),
            ("ended", str(flight["ended"])),
            ("time in AUTO", f"{flight['auto_s']:.1f} s"),
            ("RTL confirmed", "yes" if flight["rtl_confirmed"] else "no"),
            ("path error", _statistics(flight["distance_in_space_m"])),
            ("position error", _statistics(flight["distance_in_time_m"])),
        ]
        if record is not None and record.problem:
            tables["Flight"].append(("problem", record.problem))
    return tables


def _log_rows(log: Summary) -> list[tuple[str, str]]:
    vehicles = ", ".join(
        f"{each['system']}:{each['component']} ({each['fixes']} fixes)" for each in log["vehicles"]
    )
    return [
        ("file", str(log["path"])),
        ("usable fixes", str(log["fixes"])),
        ("records without a position", str(log["without_position"])),
        ("implausible fixes", str(log["rejected"])),
        ("vehicles", vehicles),
        ("flights", str(len(log["flights"]))),
    ]


def _route_rows(route: Summary) -> list[tuple[str, str]]:
    return [
        ("method", str(route["method"])),
        ("waypoints", str(route["points"])),
        ("recorded fixes covered", str(route["fixes_covered"])),
        ("length", f"{route['length_m']:.1f} m"),
        ("planned path error", _statistics(route["planned_error_m"])),
        ("predicted duration", f"{route['predicted_duration_s']:.1f} s"),
    ]


def _statistics(error: Summary) -> str:
    if error["mean"] is None:
        return "nothing to compare"
    return f"mean {error['mean']:.2f} m, p95 {error['p95']:.2f} m, max {error['max']:.2f} m"


def _mission_rows(route: Route, record: FlightRecord | None) -> list[dict[str, str]]:
    reached = dict(record.reached) if record is not None else {}
    start_s = flown_start_s(route, record) if record is not None else math.nan
    rows = []
    for seq, item in enumerate(route.mission.items, FIRST_SEQ):
        row = {"seq": str(seq), "item": _item_text(item), "lat": "", "lon": "", "alt": "", "reached": ""}
        if item.is_waypoint:
            row |= {"lat": f"{item.lat_deg:.7f}", "lon": f"{item.lon_deg:.7f}", "alt": f"{item.alt_m:.1f}"}
        if seq in reached:
            row["reached"] = f"{reached[seq] - start_s:.1f}"
        rows.append(row)
    return rows


def _item_text(item: MissionItem) -> str:
    if item.command == Command.CHANGE_SPEED:
        return f"change speed to {item.params[1]:g} m/s"
    return description(item)
