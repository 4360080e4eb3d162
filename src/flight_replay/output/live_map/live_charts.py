"""The live map's charts over time: errors, height and speed, of the plan and as they are flown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from bokeh.models import ColumnDataSource, DataRange1d
from bokeh.plotting import figure

from flight_replay.geometry.arrays import Floats
from flight_replay.output.charts.bokeh_charts import add_line, time_chart
from flight_replay.output.charts.series import FLOWN_COLOUR, NOT_COVERED, ReplaySeries
from flight_replay.output.live_map.data import MapPoint

MAX_TRAIL_POINTS = 20_000
"""Most points of what is flown, on the map and in the charts."""
_CHARTS = (
    ("path", "path error, flown to recorded", "error (m)"),
    ("position", "position error at equal times", "error (m)"),
    ("height", "height above home", "height (m)"),
    ("speed", "ground speed", "speed (m/s)"),
)


class LiveCharts:
    """Charts named "path", "position", "height" and "speed", which share their time.

    They show all of the plan until something is flown, from then on the time in which it is.
    """

    def __init__(self, series: ReplaySeries, path_error: tuple[Floats, Floats]) -> None:
        """The plan's lines, and empty ones for what is flown.

        Args:
            series: recorded, planned and predicted.
            path_error: times (n,) and the live path error (n,) that are predicted.
        """
        self._errors = ColumnDataSource({"time": [], "path": [], "position": []}, name="errors")
        self._states = ColumnDataSource({"time": [], "height": [], "speed": []}, name="states")
        self._time, self._label = DataRange1d(), series.time_label
        self.charts = {name: self._chart(name, title, y_label) for name, title, y_label in _CHARTS}
        add_line(self.charts["path"], *path_error, "predicted")
        if series.predicted_error.position is not None:
            error = series.predicted_error.position
            add_line(self.charts["position"], error.time_s, error.error, "predicted")
        self._add_plan(series)
        self._time.renderers = [
            line for chart in self.charts.values() for line in chart.renderers if line.name != NOT_COVERED
        ]
        self._flown = {name: self._flown_line(name) for name in self.charts}

    def add(self, points: Sequence[MapPoint]) -> None:
        """Show what was flown since the last call."""
        timed = [p for p in points if math.isfinite(p.elapsed_s)]
        measured = [p for p in timed if math.isfinite(p.path_error_m)]
        if timed:
            if not self._states.data["time"]:
                self._show_flown()
            states: dict[str, Any] = {
                "time": [p.elapsed_s for p in timed],
                "height": [p.up_m for p in timed],
                "speed": [p.speed_m_s for p in timed],
            }
            self._states.stream(states, MAX_TRAIL_POINTS)
        if measured:
            errors: dict[str, Any] = {
                "time": [p.elapsed_s for p in measured],
                "path": [p.path_error_m for p in measured],
                "position": [p.position_error_m for p in measured],
            }
            self._errors.stream(errors, MAX_TRAIL_POINTS)

    def _show_flown(self) -> None:
        """Fit time, and the errors, to what is flown: a plan that goes on for long would hide it."""
        self._time.renderers = list(self._flown.values())
        for name in ("path", "position"):
            y_range: Any = self.charts[name].y_range
            y_range.renderers = [self._flown[name]]

    def _chart(self, name: str, title: str, y_label: str) -> figure:
        chart = time_chart(title, self._label, y_label, x_range=self._time)
        chart.name, chart.sizing_mode = name, "stretch_both"
        chart.toolbar_location = None
        chart.min_border_right = 12
        return chart

    def _add_plan(self, series: ReplaySeries) -> None:
        height, speed = self.charts["height"], self.charts["speed"]
        for name, track in series.timed_lines:
            add_line(height, track.time_s, track.alt_m, name)
            add_line(speed, track.time_s, track.speed_m_s, name)
        if series.predicted is not None:
            add_line(height, series.predicted.time_s, series.predicted.alt_m, "predicted")
            add_line(speed, series.predicted.time_s, series.predicted.speed_m_s, "predicted")
        add_line(height, *series.planned_height, "planned")

    def _flown_line(self, name: str) -> Any:
        source = self._errors if name in ("path", "position") else self._states
        return self.charts[name].line("time", name, source=source, color=FLOWN_COLOUR, line_width=1.5)
