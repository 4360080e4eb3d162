"""The report: one self-contained HTML file with results, zoomable charts, mission, events and command."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from flight_replay.geometry.error_statistics import ErrorStatistics
from flight_replay.logs.log_formats import format_title
from flight_replay.mission.formats.item_text import description
from flight_replay.mission.items import CLIMB_SPEED, DESCENT_SPEED, FIRST_SEQ, Command, MissionItem
from flight_replay.output.charts.series import (
    FLOWN_COLOUR,
    SMALLEST_RANGE,
    ErrorSeries,
    PathErrorSeries,
    ReplaySeries,
    replay_series,
)
from flight_replay.output.event_log import LoggedEvent
from flight_replay.output.outcome import Coverage, Outcome, flown_start_s
from flight_replay.output.result_text import coverage_text, duration_text, statistics_text
from flight_replay.planning.route import Route
from flight_replay.supervisor.flight_plan import FlightRecord
from flight_replay.writing.counted import counted
from flight_replay.writing.fixed_point import fixed_point
from flight_replay.writing.output_files import check_suffix, write_atomically

if TYPE_CHECKING:
    from bokeh.model import Model
    from bokeh.models import Range
    from bokeh.plotting import figure

SUFFIXES = (".html", ".htm")
Summary = Mapping[str, Any]
_SPEEDS = {CLIMB_SPEED: "climb speed", DESCENT_SPEED: "descent speed"}
_SUMMARIES = {
    None: "Plan only: nothing was flown.",
    "duration": "Flown for the requested duration.",
    "final waypoint": "Flown until the vehicle headed for the final waypoint.",
    "mission complete": "The whole mission was flown.",
    "recording complete": "The whole motion was followed.",
}


@dataclass(frozen=True, slots=True)
class ReportText:
    """The text of a report.

    ``summary`` is the ``--json`` object, ``events`` are the entries of an ``EventLog``, ``argv`` the
    arguments that repeat this run, without the program's name.
    """

    summary: Summary
    events: Sequence[LoggedEvent] = ()
    argv: Sequence[str] = ()


def save_report(path: Path | str, text: ReportText, route: Route, outcome: Outcome | None = None) -> None:
    """Write the report of a plan, and of the flight that followed it if there was one.

    Raises:
        FlightReplayError: The suffix is not in ``SUFFIXES``, or the file cannot be written.
    """
    check_suffix(path, SUFFIXES)
    from bokeh.embed import file_html
    from bokeh.resources import Resources
    from jinja2 import Template

    record = None if outcome is None else outcome.record
    template = files("flight_replay.output.charts").joinpath("report.html").read_text(encoding="utf-8")
    page = file_html(
        _charts(replay_series(route, outcome)),
        resources=Resources(mode="inline"),
        title=f"Replay of {PurePath(str(text.summary['log']['path'])).name}",
        template=Template(template),
        template_variables={
            "lead": _lead(record),
            "tables": _tables(text.summary, route, outcome),
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
        paths.line(east_m, north_m, color=FLOWN_COLOUR, line_width=1.8, legend_label="flown")
    return [paths, column(*_time_charts(series), sizing_mode="stretch_width", name="over_time")]


def _time_charts(series: ReplaySeries) -> list[Model]:
    """Errors, altitude and speed over one time axis; what is predicted where nothing was flown."""
    from flight_replay.output.charts.bokeh_charts import add_line, time_chart

    altitude = time_chart("altitude above home", series.time_label, "altitude (m)")
    speed = time_chart("ground speed", series.time_label, "speed (m/s)", x_range=altitude.x_range)
    for name, track in series.timed_lines:
        add_line(altitude, track.time_s, track.alt_m, name)
        add_line(speed, track.time_s, track.speed_m_s, name)
    lines = {"predicted": series.predicted_unflown, "planned": None, "flown": series.flown}
    for name, flight in lines.items():
        if name == "planned" and series.timed:
            add_line(altitude, *series.planned_height, name)
        elif flight is not None:
            add_line(altitude, flight.time_s, flight.alt_m, name)
            add_line(speed, flight.time_s, flight.speed_m_s, name)
    charts = [chart for chart in (altitude, speed) if chart.renderers]
    for chart in charts:
        _begin_at_zero(chart)
    return [*_error_charts(series), *charts]


def _begin_at_zero(chart: figure) -> None:
    """Show 0, too, and some range above it, as the plot does: millimetres must not look like much."""
    lines, y_range = cast("list[Any]", chart.renderers), cast("Any", chart.y_range)
    if all(np.nanmin(line.data_source.data["y"], initial=0.0) >= 0.0 for line in lines):
        y_range.start = 0
    if all(np.nanmax(line.data_source.data["y"], initial=0.0) < SMALLEST_RANGE for line in lines):
        y_range.end = SMALLEST_RANGE


def _errors_shown(series: ReplaySeries) -> list[tuple[str, str, ErrorSeries | None, ErrorSeries | None]]:
    """Title, label of the axis, and the lines planned and flown, or predicted, of every chart of errors."""
    plan, shown = series.planned_error, series.shown_error
    path = shown.path or PathErrorSeries(None, None)
    metres = "error (m)"
    return [
        ("path error: recorded fixes to the path", metres, plan.recorded_to_path, path.recorded_to_path),
        ("path error: the path to the recorded line", metres, plan.path_to_recorded, path.path_to_recorded),
        ("position error at equal times", metres, None, shown.position),
        ("height error at equal times", metres, None, shown.height),
        ("heading error at equal times", "error (degrees)", None, shown.heading),
    ]


def _error_charts(series: ReplaySeries) -> list[Model]:
    """A chart of each of the errors that there are, planned as far as was flown, over one time axis."""
    from bokeh.models import Range1d

    from flight_replay.output.charts.bokeh_charts import add_line, time_chart

    charts: list[Model] = []
    x_range: Range | None = None
    for title, y_label, planned, flown in _errors_shown(series):
        if planned is None and flown is None:
            continue
        chart = time_chart(title, series.error_label, y_label, x_range=x_range)
        x_range = chart.x_range
        if max(each.statistics.max for each in (planned, flown) if each is not None) < SMALLEST_RANGE:
            chart.y_range = Range1d(start=0, end=SMALLEST_RANGE)
        end_s = math.inf if flown is None else flown.time_s[-1]
        lines = (("planned", planned), ("flown", flown))
        if series.flown is None:
            lines = (("predicted", flown), ("planned", planned))  # What is wide is drawn first.
        for name, errors in lines:
            if errors is not None:
                shown = errors.time_s <= end_s
                add_line(chart, errors.time_s[shown], errors.error[shown], name)
        charts.append(chart)
    return charts


def _tables(summary: Summary, route: Route, outcome: Outcome | None) -> dict[str, list[tuple[str, str]]]:
    """Rows of (label, value) by heading."""
    tables = {"Log": _log_rows(summary["log"], route), "Route": _route_rows(summary["route"])}
    flight = summary.get("flight")
    if flight is not None and outcome is not None:
        tables["Flight"] = [
            ("vehicle", str(flight["vehicle"])),
            *_waypoint_rows(summary),
            ("ended", str(flight["ended"])),
            (f"time in {_mode(summary['route'])}", f"{flight['auto_s']:.1f} s"),
            ("RTL confirmed", "yes" if flight["rtl_confirmed"] else "no"),
            *_coverage_rows(outcome.coverage),
            *_error_rows(flight),
        ]
        if outcome.record.problem:
            tables["Flight"].append(("problem", outcome.record.problem))
    return tables


def _mode(route: Summary) -> str:
    """The mode in which the recording is flown."""
    return "GUIDED" if "reference" in route else "AUTO"


def _waypoint_rows(summary: Summary) -> list[tuple[str, str]]:
    if "reference" in summary["route"]:
        waited_s = summary["flight"]["alignment"]["waited_s"]
        return [("waited for the vehicle", f"{waited_s or 0.0:.1f} s")]
    return [
        ("waypoints reached", f"{summary['flight']['waypoints_reached']} of {summary['route']['points']}")
    ]


def _log_rows(log: Summary, route: Route) -> list[tuple[str, str]]:
    vehicles = ", ".join(
        f"{each['system']}:{each['component']} ({counted(each['fixes'], 'fix')})" for each in log["vehicles"]
    )
    return [
        ("file", str(log["path"])),
        ("format", format_title(log["format"])),
        *_when_where_and_what(log, route),
        ("usable fixes", str(log["fixes"])),
        ("records without a position", str(log["without_position"])),
        ("implausible fixes", str(log["rejected"])),
        *([("vehicles", vehicles)] if vehicles else []),  # GPX and tables know none.
        ("flights", str(len(log["flights"]))),
    ]


def _when_where_and_what(log: Summary, route: Route) -> list[tuple[str, str]]:
    """When and where the recording begins, how long it flies, and what flew, as far as the log tells."""
    rows = []
    if log["start_utc_s"] is not None:
        begin = datetime.fromtimestamp(log["start_utc_s"], timezone.utc)
        rows.append(("date", f"{begin:%Y-%m-%d %H:%M:%S} UTC"))
    home, recording = route.mission.home, route.recording
    if home is not None:
        rows.append(("place", f"home at {home.lat_deg:.6f}°, {home.lon_deg:.6f}°"))
    if recording.timed:
        rows.append(("duration", duration_text(float(recording.time_s[-1] - recording.time_s[0]))))
    vehicle = ", ".join(filter(None, [log["vehicle_type"], log["firmware"]]))
    return [*rows, ("recorded vehicle", vehicle)] if vehicle else rows


def _route_rows(route: Summary) -> list[tuple[str, str]]:
    return [
        ("method", str(route["method"])),
        *_what_is_flown_rows(route),
        ("recorded fixes covered", str(route["fixes_covered"])),
        ("length", f"{route['length_m']:.1f} m"),
        *_path_error_rows("planned path error", route["planned_error_m"]),
        ("predicted duration", f"{route['predicted_duration_s']:.1f} s"),
        *(_error_rows(route["predicted"], "predicted ") if route["predicted"] else ()),
    ]


def _what_is_flown_rows(route: Summary) -> list[tuple[str, str]]:
    """The waypoints of a mission, or the motion that is followed."""
    motion = route.get("reference")
    if motion is None:
        return [("waypoints", str(route["points"]))]
    return [
        ("top speed", f"{motion['top_speed_m_s']:.1f} m/s"),
        ("top acceleration", f"{motion['top_acceleration_m_s2']:.1f} m/s²"),
        ("altitude above home", f"{fixed_point(motion['lowest_m'], 1)} to {motion['highest_m']:.1f} m"),
    ]


def _coverage_rows(coverage: Coverage) -> list[tuple[str, str]]:
    """Which part of what was to be replayed was flown, and how to fly all of it."""
    rows = [("flown", coverage_text(coverage))]
    if coverage.fly_all:
        rows.append(("to fly all of it", " ".join(coverage.fly_all)))
    return rows


def _error_rows(errors: Summary, prefix: str = "") -> list[tuple[str, str]]:
    """Rows of all errors of a flight, flown or predicted."""
    return [
        *_path_error_rows(f"{prefix}path error", errors["path_error_m"]),
        (f"{prefix}position error", _statistics(errors["position_error_m"])),
        (f"{prefix}height error", _statistics(errors["height_error_m"])),
        (f"{prefix}heading error", _statistics(errors["heading_error_deg"], "deg")),
    ]


def _path_error_rows(label: str, errors: Summary) -> list[tuple[str, str]]:
    return [(f"{label}, {way.replace('_', ' ')}", _statistics(error)) for way, error in errors.items()]


def _statistics(error: Summary | None, unit: str = "m") -> str:
    if error is None or error["mean"] is None:
        return statistics_text(None)
    values = statistics_text(ErrorStatistics(**error), unit).split(", ")
    # Lines break between the values, not within one.
    return ", ".join(value.replace(" ", "\N{NO-BREAK SPACE}") for value in values)


def _mission_rows(route: Route, record: FlightRecord | None) -> list[dict[str, str]]:
    reached = dict(record.reached) if record is not None else {}
    start_s = flown_start_s(route, record) if record is not None else math.nan
    rows = []
    items = () if route.reference is not None else route.mission.items
    for seq, item in enumerate(items, FIRST_SEQ):
        row = {"seq": str(seq), "item": _item_text(item), "lat": "", "lon": "", "alt": "", "reached": ""}
        if item.is_waypoint or item.command == Command.SET_ROI:
            row |= {"lat": fixed_point(item.lat_deg, 7), "lon": fixed_point(item.lon_deg, 7)}
            row["alt"] = fixed_point(item.alt_m, 1)
        if item.is_waypoint and seq in reached:  # A turn is passed long before it is made.
            row["reached"] = fixed_point(reached[seq] - start_s, 1)
        rows.append(row)
    return rows


def _item_text(item: MissionItem) -> str:
    if item.command == Command.CHANGE_SPEED:
        which = _SPEEDS.get(int(item.params[0]), "speed")
        return f"change {which} to {item.params[1]:g} m/s"
    if item.command == Command.LOITER_TIME:
        return f"wait here for {item.params[0]:g} s"
    if item.command == Command.CONDITION_YAW:
        return f"turn to {item.params[0]:g}°" + (f" at {item.params[1]:g}°/s" if item.params[1] else "")
    if item.command == Command.CONDITION_DELAY:
        return f"next turn after {item.params[0]:g} s"
    if item.command == Command.SET_ROI:
        return "face this position"
    return description(item)
