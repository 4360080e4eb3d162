"""The page of the live map: its charts and readings, updated ten times a second."""

from __future__ import annotations

import math
import threading
from html import escape
from importlib.resources import files
from typing import Any

from bokeh.document import Document
from bokeh.models import ColumnDataSource, CustomJS
from bokeh.models.widgets import Div
from jinja2 import Template

from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.output.charts.bokeh_charts import map_chart, time_chart
from flight_replay.output.charts.map_tiles import tile_source
from flight_replay.output.charts.series import FLOWN_COLOUR, ReplaySeries
from flight_replay.output.live_map.data import MapData, MapPoint
from flight_replay.output.replay_status import ReplayStatus, battery_text, following_text

TICK_MS = 100
"""Milliseconds between two updates of the page."""
MAX_TRAIL_POINTS = 20_000
# After the flight the server stops, which the page must not report as a lost connection.
_EXPECT_DISCONNECT = (
    "Object.assign(cb_obj.document.config, {reconnect_session: false, notify_connection_status: false})"
)
_CELL = "display:inline-block;min-width:7.5em;margin:0 14px 6px 0"


class Page:
    """The page in one browser."""

    def __init__(
        self, data: MapData, series: ReplaySeries, frame: LocalFrame, tiles: threading.Event
    ) -> None:
        self._data, self._frame, self._tiles = data, frame, tiles
        self._next = 0
        self._trail = ColumnDataSource({"east": [], "north": []}, name="trail")
        self._copter = ColumnDataSource({"east": [], "north": [], "angle": []}, name="copter")
        self._target = ColumnDataSource({"east": [], "north": [], "seq": []}, name="target")
        self._errors = ColumnDataSource({"time": [], "path": [], "position": []}, name="errors")
        self._readings = Div(name="readings", sizing_mode="stretch_width")
        self._readings.js_on_change("tags", CustomJS(code=_EXPECT_DISCONNECT))
        self._map = map_chart(series)
        self._time_label = series.time_label
        self._draw_vehicle()

    def fill(self, document: Document) -> None:
        """Add the page to a browser's document, and update it from then on."""
        document.title = "Replay in flight"
        document.template = _template()
        self._map.name, self._map.sizing_mode = "map", "stretch_both"
        document.add_root(self._map)
        document.add_root(self._readings)
        document.add_root(self._error_chart("path", "path error, flown to recorded"))
        document.add_root(self._error_chart("position", "position error at equal times"))
        self.tick()
        if self._readings.tags:
            document.config.update(reconnect_session=False, notify_connection_status=False)
        document.add_periodic_callback(self.tick, TICK_MS)

    def tick(self) -> None:
        """Show the events since the last tick."""
        points = self._data.points(self._next)
        self._next += len(points)
        if points:
            self._add(points)
        self._update_target()
        text = readings_html(self._data.status, self._data.points(self._next - 1)[:1] if self._next else [])
        if text != self._readings.text:
            self._readings.text = text
        if self._data.status.ended is not None and not self._readings.tags:
            self._readings.tags = ["ended"]
        if self._tiles.is_set():
            self._tiles = threading.Event()
            self._map.add_tile(tile_source(self._frame), level="image")

    def _draw_vehicle(self) -> None:
        chart = self._map
        chart.line("east", "north", source=self._trail, color=FLOWN_COLOUR, width=2, legend_label="flown")
        chart.scatter(
            "east", "north", source=self._target, size=18, fill_color=None, line_color="black", line_width=2
        )
        chart.text(
            "east", "north", text="seq", source=self._target, x_offset=12, y_offset=20, text_font_style="bold"
        )
        chart.ray(
            "east", "north", angle="angle", source=self._copter, length=26, length_units="screen",
            line_width=4, line_color="black",
        )  # fmt: skip
        chart.scatter(
            "east", "north", source=self._copter, size=13, fill_color=FLOWN_COLOUR, line_color="black"
        )

    def _error_chart(self, name: str, title: str) -> Any:
        chart = time_chart(title, self._time_label, "error (m)")
        chart.line("time", name, source=self._errors, color=FLOWN_COLOUR, width=1.5)
        chart.name, chart.sizing_mode = name, "stretch_both"
        chart.toolbar_location = None
        return chart

    def _add(self, points: list[MapPoint]) -> None:
        self._trail.stream(
            {"east": [p.east_m for p in points], "north": [p.north_m for p in points]}, MAX_TRAIL_POINTS
        )
        timed = [p for p in points if math.isfinite(p.elapsed_s)]
        if timed:
            self._errors.stream(
                {
                    "time": [p.elapsed_s for p in timed],
                    "path": [p.path_error_m for p in timed],
                    "position": [p.position_error_m for p in timed],
                },
                MAX_TRAIL_POINTS,
            )
        vehicle = self._data.status.vehicle
        heading_deg = vehicle.heading_deg if vehicle is not None else None
        angle = math.radians(90 - (heading_deg or 0.0))
        last = points[-1]
        self._copter.data = {"east": [last.east_m], "north": [last.north_m], "angle": [angle]}

    def _update_target(self) -> None:
        """Mark where the vehicle is to be."""
        target: dict[str, list[Any]] = {"east": [], "north": [], "seq": []}
        current = self._data.target()
        if current is not None:
            target = {"east": [current.east_m], "north": [current.north_m], "seq": [current.label]}
        if target != self._target.data:
            self._target.data = target


def _template() -> Template:
    text = files("flight_replay.output.live_map").joinpath("map.html").read_text(encoding="utf-8")
    template: Template = Template(text)
    return template


def readings_html(status: ReplayStatus, last: list[MapPoint]) -> str:
    """Phase, waypoint or time of the recording, what the vehicle reports, and errors.

    ``last`` holds the latest point, if any.
    """
    values = {"Phase": _phase(status)}
    if status.current_waypoint is not None:
        values["Waypoint"] = f"{status.current_waypoint.number} of {status.current_waypoint.waypoints}"
    if status.following is not None:
        name = "Waiting for the vehicle" if status.following.waiting else "Following"
        values[name] = following_text(status.following)
    if status.vehicle is not None:
        values["Altitude"] = f"{status.vehicle.alt_m:.1f} m"
        values["Speed"] = f"{status.speed_m_s:.1f} m/s"
        values["Mode"] = status.mode
        values["Battery"] = battery_text(status.vehicle)
    for point in last:
        values["Path error"] = _metres(point.path_error_m)
        values["Position error"] = _metres(point.position_error_m)
        values["Height error"] = _metres(point.height_error_m)
        values["Heading error"] = (
            f"{point.heading_error_deg:.0f}°" if math.isfinite(point.heading_error_deg) else ""
        )
    if status.warning:
        values["Warning"] = status.warning
    cells = (
        f'<span style="{_CELL}"><small style="color:#666">{label}</small><br><b>{escape(value)}</b></span>'
        for label, value in values.items()
        if value
    )
    return f'<div style="font:15px/1.3 system-ui,sans-serif">{"".join(cells)}</div>'


def _phase(status: ReplayStatus) -> str:
    if status.ended is not None:
        return f"ended: {status.ended}"
    name = status.phase.value if status.phase is not None else "planning"
    return f"{name}: {status.waiting}" if status.waiting else name


def _metres(distance_m: float) -> str:
    return f"{distance_m:.1f} m" if math.isfinite(distance_m) else ""
