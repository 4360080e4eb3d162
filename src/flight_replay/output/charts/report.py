"""A replay in one self-contained HTML file: zoomable charts, numbers, mission, events, how to repeat it."""

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
from flight_replay.output.charts.series import Curves, curves, start_s
from flight_replay.output.event_log import Entry
from flight_replay.output.outcome import Outcome
from flight_replay.output_files import check_suffix, write_atomically
from flight_replay.planning.route import Route
from flight_replay.supervisor.flight_plan import FlightRecord

if TYPE_CHECKING:
    from bokeh.model import Model

SUFFIXES = (".html", ".htm")
Summary = Mapping[str, Any]
_LEADS = {
    None: "A plan: nothing was flown.",
    "duration": "Flown for the time asked for.",
    "final waypoint": "Flown until the vehicle headed for the final waypoint.",
    "mission complete": "The whole mission was flown.",
}


@dataclass(frozen=True, slots=True)
class Account:
    """What the report tells in words.

    ``summary`` is the ``--json`` object, ``events`` what a ``Journal`` kept of the flight, ``argv``
    the arguments of this run without the program's name.
    """

    summary: Summary
    events: Sequence[Entry] = ()
    argv: Sequence[str] = ()


def save_report(
    path: Path | str,
    account: Account,
    route: Route,
    record: FlightRecord | None = None,
    outcome: Outcome | None = None,
) -> None:
    """Write the report of a plan, and of the flight that followed it if there was one.

    Raises:
        FlightReplayError: The suffix is not HTML's, or the file cannot be written.
    """
    check_suffix(path, SUFFIXES)
    from bokeh.embed import file_html
    from bokeh.resources import Resources
    from jinja2 import Template

    template = files("flight_replay.output.charts").joinpath("report.html").read_text(encoding="utf-8")
    page = file_html(
        _charts(curves(route, record, outcome)),
        resources=Resources(mode="inline"),
        title=f"Replay of {PurePath(str(account.summary['log']['path'])).name}",
        template=Template(template),
        template_variables={
            "lead": _lead(record),
            "facts": _facts(account.summary, record),
            "mission": _mission_rows(route, record),
            "events": account.events,
            "command": shlex.join(["flight-replay", *account.argv]),
            "made_by": f"Made by flight-replay {version('flight-replay')}. All of it is in this one file.",
        },
    )
    write_atomically(path, page)


def _lead(record: FlightRecord | None) -> str:
    ended = record.ended if record is not None else None
    return _LEADS.get(ended, f"The flight ended otherwise than asked, by: {ended}.")


def _charts(shown: Curves) -> list[Model]:
    from bokeh.layouts import column

    from flight_replay.output.charts.bokeh_charts import add_line, map_chart, time_chart
    from flight_replay.output.charts.series import FLOWN

    paths = map_chart(shown, height=560)
    if shown.flown is not None:
        flown = shown.flown.north_east_m
        paths.line(flown[:, 1], flown[:, 0], color=FLOWN, width=1.8, legend_label="flown")
    space = time_chart("distance in space of the recorded fixes from the path", "distance (m)")
    together = space.x_range
    add_line(space, shown.planned_distance.time_s, shown.planned_distance.distance_m, "planned")
    altitude = time_chart("altitude above home", "altitude (m)", x_range=together)
    speed = time_chart("ground speed", "speed (m/s)", x_range=together)
    add_line(altitude, shown.recorded.time_s, shown.recorded.alt_m, "recorded")
    add_line(speed, shown.recorded.time_s, shown.recorded.speed_m_s, "recorded")
    charts = [space, altitude, speed]
    if shown.in_space is not None:
        add_line(space, shown.in_space.time_s, shown.in_space.distance_m, "flown")
    if shown.in_time is not None:
        late = time_chart(
            "distance in time of the recorded from the flown position", "distance (m)", x_range=together
        )
        add_line(late, shown.in_time.time_s, shown.in_time.distance_m, "flown")
        charts.insert(1, late)
    if shown.flown is not None:
        add_line(altitude, shown.flown.time_s, shown.flown.alt_m, "flown")
        add_line(speed, shown.flown.time_s, shown.flown.speed_m_s, "flown")
    over_time = column(*charts, sizing_mode="stretch_width", name="over_time")
    paths.name = "paths"
    return [paths, over_time]


def _facts(summary: Summary, record: FlightRecord | None) -> dict[str, list[tuple[str, str]]]:
    """Tables of labels and values, by heading."""
    facts = {"Log": _log_facts(summary["log"]), "Route": _route_facts(summary["route"])}
    flight = summary.get("flight")
    if flight is not None:
        facts["Flight"] = [
            ("vehicle", f"{flight['vehicle']} ({'simulated' if flight['simulated'] else 'real'})"),
            ("waypoints reached", f"{flight['waypoints_reached']} of {summary['route']['points']}"),
            ("ended by", str(flight["ended"])),
            ("time in AUTO", f"{flight['auto_s']:.1f} s"),
            ("RTL confirmed", "yes" if flight["rtl_confirmed"] else "no"),
            ("distance in space", _spread(flight["distance_in_space_m"])),
            ("distance in time", _spread(flight["distance_in_time_m"])),
        ]
        if record is not None and record.problem:
            facts["Flight"].append(("problem", record.problem))
    return facts


def _log_facts(log: Summary) -> list[tuple[str, str]]:
    vehicles = ", ".join(
        f"{each['system']}/{each['component']}: {each['fixes']} fixes" for each in log["vehicles"]
    )
    return [
        ("file", str(log["path"])),
        ("usable fixes", str(log["fixes"])),
        ("records without a position", str(log["without_position"])),
        ("not believable", str(log["rejected"])),
        ("vehicles", vehicles),
        ("flights", str(len(log["flights"]))),
    ]


def _route_facts(route: Summary) -> list[tuple[str, str]]:
    return [
        ("made by", str(route["method"])),
        ("waypoints", str(route["points"])),
        ("recorded fixes covered", str(route["fixes_covered"])),
        ("length", f"{route['length_m']:.1f} m"),
        ("planned error", _spread(route["planned_error_m"])),
        ("predicted duration", f"{route['predicted_duration_s']:.1f} s"),
    ]


def _spread(spread: Summary) -> str:
    if spread["mean"] is None:
        return "nothing to compare"
    return f"mean {spread['mean']:.2f}, 95 % {spread['p95']:.2f}, max {spread['max']:.2f} m"


def _mission_rows(route: Route, record: FlightRecord | None) -> list[dict[str, str]]:
    reached = dict(record.reached) if record is not None else {}
    zero_s = start_s(route, record) if record is not None else math.nan
    rows = []
    for seq, item in enumerate(route.mission.items, FIRST_SEQ):
        row = {"seq": str(seq), "what": _what(item), "lat": "", "lon": "", "alt": "", "reached": ""}
        if item.is_waypoint:
            row |= {"lat": f"{item.lat_deg:.7f}", "lon": f"{item.lon_deg:.7f}", "alt": f"{item.alt_m:.1f}"}
        if seq in reached:
            row["reached"] = f"{reached[seq] - zero_s:.1f}"
        rows.append(row)
    return rows


def _what(item: MissionItem) -> str:
    if item.command == Command.CHANGE_SPEED:
        return f"change speed to {item.params[1]:g} m/s"
    return description(item)
