"""One page of the live map: its charts, and what is added to them ten times a second."""

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
from flight_replay.output.charts.series import FLOWN, Curves
from flight_replay.output.live_map.data import LiveData, Point
from flight_replay.output.replay_status import Status

TICK_MS = 100
"""Between updates; what happens shows on the page at most this, and the browser's own time, later."""
MOST_POINTS = 20_000
# Once the flight has ended, the server's going away is what comes next and needs no alarm.
_CALM = "Object.assign(cb_obj.document.config, {reconnect_session: false, notify_connection_status: false})"
_CELL = "display:inline-block;min-width:7.5em;margin:0 14px 6px 0"


class Page:
    """The page of one browser."""

    def __init__(self, data: LiveData, shown: Curves, frame: LocalFrame, tiles: threading.Event) -> None:
        self._data, self._frame, self._tiles = data, frame, tiles
        self._next = 0
        self._trail = ColumnDataSource({"east": [], "north": []}, name="trail")
        self._copter = ColumnDataSource({"east": [], "north": [], "angle": []}, name="copter")
        self._target = ColumnDataSource({"east": [], "north": [], "seq": []}, name="target")
        self._errors = ColumnDataSource({"time": [], "space": [], "late": []}, name="errors")
        self._readings = Div(name="readings", sizing_mode="stretch_width")
        self._readings.js_on_change("tags", CustomJS(code=_CALM))
        self._map = map_chart(shown)
        self._draw_vehicle()

    def fill(self, document: Document) -> None:
        """Put the page into a browser's document, and keep it up to date."""
        document.title = "Replay in flight"
        document.template = _template()
        self._map.name, self._map.sizing_mode = "map", "stretch_both"
        document.add_root(self._map)
        document.add_root(self._readings)
        document.add_root(self._error_chart("space", "distance in space from the recorded path"))
        document.add_root(self._error_chart("time", "distance in time from the recorded position"))
        self.tick()
        if self._readings.tags:
            document.config.update(reconnect_session=False, notify_connection_status=False)
        document.add_periodic_callback(self.tick, TICK_MS)

    def tick(self) -> None:
        """Show what has happened since the last tick."""
        points = self._data.points(self._next)
        self._next += len(points)
        if points:
            self._add(points)
        self._point_out()
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
        chart.line("east", "north", source=self._trail, color=FLOWN, width=2, legend_label="flown")
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
        chart.scatter("east", "north", source=self._copter, size=13, fill_color=FLOWN, line_color="black")

    def _error_chart(self, name: str, title: str) -> Any:
        chart = time_chart(title, "distance (m)")
        chart.xaxis[0].axis_label = "time since the first waypoint (s)"
        chart.line(
            "time", "space" if name == "space" else "late", source=self._errors, color=FLOWN, width=1.5
        )
        chart.name, chart.sizing_mode = name, "stretch_both"
        chart.toolbar_location = None
        return chart

    def _add(self, points: list[Point]) -> None:
        self._trail.stream(
            {"east": [p.east_m for p in points], "north": [p.north_m for p in points]}, MOST_POINTS
        )
        timed = [p for p in points if math.isfinite(p.elapsed_s)]
        if timed:
            self._errors.stream(
                {
                    "time": [p.elapsed_s for p in timed],
                    "space": [p.in_space_m for p in timed],
                    "late": [p.in_time_m for p in timed],
                },
                MOST_POINTS,
            )
        vehicle = self._data.status.vehicle
        heading_deg = vehicle.heading_deg if vehicle is not None else None
        angle = math.radians(90 - (heading_deg or 0.0))
        last = points[-1]
        self._copter.data = {"east": [last.east_m], "north": [last.north_m], "angle": [angle]}

    def _point_out(self) -> None:
        """Ring the waypoint that the vehicle flies to."""
        target, heading = self._data.target_m(), self._data.status.heading
        shown = {"east": [], "north": [], "seq": []} if target is None or heading is None else {
            "east": [target[1]], "north": [target[0]], "seq": [str(heading.seq)],
        }  # fmt: skip
        if shown != self._target.data:
            self._target.data = shown


def _template() -> Template:
    text = files("flight_replay.output.live_map").joinpath("map.html").read_text(encoding="utf-8")
    template: Template = Template(text)
    return template


def readings_html(status: Status, last: list[Point]) -> str:
    """Phase, waypoint, altitude, speed, battery and the distances as they are now."""
    pairs = {"Phase": _phase(status)}
    if status.heading is not None:
        pairs["Waypoint"] = f"{status.heading.seq} of {status.heading.last_seq}"
    if status.vehicle is not None:
        vehicle = status.vehicle
        pairs |= {"Altitude": f"{vehicle.alt_m:.1f} m", "Speed": f"{status.speed_m_s:.1f} m/s"}
        pairs |= {"Mode": vehicle.mode, "Battery": _battery(vehicle.battery_v, vehicle.battery_percent)}
    for point in last:
        pairs |= {"Off in space": _metres(point.in_space_m), "Off in time": _metres(point.in_time_m)}
    if status.trouble:
        pairs["Warning"] = status.trouble
    cells = (
        f'<span style="{_CELL}"><small style="color:#666">{label}</small><br><b>{escape(value)}</b></span>'
        for label, value in pairs.items()
        if value
    )
    return f'<div style="font:15px/1.3 system-ui,sans-serif">{"".join(cells)}</div>'


def _phase(status: Status) -> str:
    if status.ended is not None:
        return f"ended: {status.ended}"
    name = status.phase.value if status.phase is not None else "planning"
    return f"{name}: {status.waiting}" if status.waiting else name


def _metres(distance_m: float) -> str:
    return f"{distance_m:.1f} m" if math.isfinite(distance_m) else ""


def _battery(volts: float | None, percent: float | None) -> str:
    return " ".join(
        text
        for text in (
            "" if volts is None else f"{volts:.1f} V",
            "" if percent is None else f"{percent:.0f} %",
        )
        if text
    )
