"""The page of the live map: its charts and readings, updated ten times a second."""

from __future__ import annotations

import math
import threading
from importlib.resources import files
from typing import Any

from bokeh.document import Document
from bokeh.models import ColumnDataSource, CustomJS
from bokeh.models.annotations import LegendItem
from bokeh.models.widgets import Div
from jinja2 import Template

from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.output.charts.bokeh_charts import map_chart
from flight_replay.output.charts.map_tiles import tile_source
from flight_replay.output.charts.series import FLOWN_COLOUR, ReplaySeries
from flight_replay.output.live_map.data import MapData, MapPoint
from flight_replay.output.live_map.live_charts import MAX_TRAIL_POINTS, LiveCharts
from flight_replay.output.live_map.readings import plan_readings, readings_html

TICK_MS = 100
"""Milliseconds between two updates of the page."""
# After the flight the server stops, which the page must not report as a lost connection. The server is not
# told of the change: its document does not know the object.
_EXPECT_DISCONNECT = (
    "cb_obj.document.config.setv({reconnect_session: false, notify_connection_status: false}, {sync: false})"
)


class Page:
    """The page in one browser."""

    def __init__(
        self, data: MapData, series: ReplaySeries, frame: LocalFrame, tiles: threading.Event
    ) -> None:
        self._data, self._frame, self._tiles = data, frame, tiles
        self._next = 0
        self._last_out: list[MapPoint] = []
        self._plan = plan_readings(data.route)
        self._trail = ColumnDataSource({"east": [], "north": []}, name="trail")
        self._return = ColumnDataSource({"east": [], "north": []}, name="return")
        self._copter = ColumnDataSource({"east": [], "north": [], "angle": []}, name="copter")
        self._target = ColumnDataSource({"east": [], "north": [], "seq": []}, name="target")
        self._readings = Div(name="readings", sizing_mode="stretch_width")
        self._readings.js_on_change("tags", CustomJS(code=_EXPECT_DISCONNECT))
        self._map = map_chart(series)
        self._home: Any = self._map.select_one({"name": "home"})
        self._charts = LiveCharts(series, data.predicted_path_error)
        self._lines = self._draw_vehicle()

    def fill(self, document: Document) -> None:
        """Add the page to a browser's document, and update it from then on."""
        document.title = "Replay in flight"
        document.template = _template()
        self._map.name, self._map.sizing_mode = "map", "stretch_both"
        document.add_root(self._map)
        document.add_root(self._readings)
        for chart in self._charts.charts.values():
            document.add_root(chart)
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
        self._update_home()
        last = self._data.points(self._next - 1)[:1] if self._next else []
        text = readings_html(self._data.status, last, self._plan)
        if text != self._readings.text:
            self._readings.text = text
        if self._data.status.ended is not None and not self._readings.tags:
            self._readings.tags = ["ended"]
        if self._tiles.is_set():
            self._tiles = threading.Event()
            self._map.add_tile(tile_source(self._frame), level="image")

    def _draw_vehicle(self) -> dict[str, Any]:
        """Draw vehicle and target; the lines that are in the legend once they are there, by their names."""
        chart = self._map
        lines = {
            "flown": chart.line("east", "north", source=self._trail, color=FLOWN_COLOUR, line_width=2),
            "flown, returning (RTL)": chart.line(
                "east", "north", source=self._return, color=FLOWN_COLOUR, line_width=2, line_dash="dotted"
            ),
        }
        chart.scatter(
            "east", "north", source=self._target, size=18, fill_color=None, line_color="black", line_width=2
        )
        chart.text(
            "east", "north", text="seq", source=self._target, x_offset=12, y_offset=20, text_font_style="bold"
        )
        chart.ray(
            "east", "north", angle="angle", source=self._copter, length=26, length_units="screen",
            line_width=4, line_color="black", level="annotation",
        )  # fmt: skip
        chart.scatter(
            "east", "north", source=self._copter, size=13, fill_color=FLOWN_COLOUR, line_color="black",
            level="annotation",
        )  # fmt: skip
        return lines

    def _add(self, points: list[MapPoint]) -> None:
        out, back = ([p for p in points if p.returns == returns] for returns in (False, True))
        if back and not self._return.data["east"]:
            back = [*(out or self._last_out)[-1:], *back]  # Both lines are one way.
        self._last_out = out or self._last_out
        for (name, line), source, flown in zip(
            self._lines.items(), (self._trail, self._return), (out, back), strict=True
        ):
            if not flown:
                continue
            if not source.data["east"]:
                legend: Any = self._map.legend[0]
                legend.items.append(LegendItem(label=name, renderers=[line]))
            source.stream(
                {"east": [p.east_m for p in flown], "north": [p.north_m for p in flown]}, MAX_TRAIL_POINTS
            )
        self._charts.add(points)
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

    def _update_home(self) -> None:
        """Move home to where the vehicle was armed."""
        home_m = self._data.home_m
        if home_m is not None and self._home.data["north"] != [home_m[0]]:
            self._home.data = {"north": [home_m[0]], "east": [home_m[1]]}


def _template() -> Template:
    text = files("flight_replay.output.live_map").joinpath("map.html").read_text(encoding="utf-8")
    template: Template = Template(text)
    return template
