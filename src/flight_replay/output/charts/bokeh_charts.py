"""Bokeh charts of a replay: the paths to scale and what goes over time, for the report and the live map.

Imported only by those two: Bokeh takes a third of a second.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from bokeh.models import ColumnDataSource, DataRange1d, HoverTool, Range
from bokeh.plotting import figure

from flight_replay.geometry.arrays import Floats
from flight_replay.output.charts.series import FLOWN, PLANNED, RECORDED, Curves

MAP_TOOLS = "pan,wheel_zoom,box_zoom,reset,save"
LABEL_SHARE = 0.08
"""Numbers of waypoints stand at least this share of the map's larger side apart."""
_MARGIN_SHARE = 0.08
_LABEL_OFFSET_PX = 13


def map_chart(shown: Curves, *, height: int = 460) -> figure:
    """The recorded and the planned path to scale, north up, waypoints with their numbers."""
    chart = figure(
        height=height,
        match_aspect=True,
        x_axis_label="east of the first fix (m)",
        y_axis_label="north of the first fix (m)",
        tools=MAP_TOOLS,
        active_scroll="wheel_zoom",
        sizing_mode="stretch_width",
        x_range=DataRange1d(range_padding=_MARGIN_SHARE),
        y_range=DataRange1d(range_padding=_MARGIN_SHARE),
    )
    chart.toolbar.logo = None
    recorded, planned = shown.recorded.north_east_m, shown.planned_m
    chart.line(recorded[:, 1], recorded[:, 0], color=RECORDED, width=5, legend_label="recorded")
    chart.line(
        planned[:, 1], planned[:, 0], color=PLANNED, width=1.5, line_dash="dashed", legend_label="planned"
    )
    _add_waypoints(chart, shown)
    chart.legend.orientation = "horizontal"
    chart.add_layout(chart.legend[0], "above")
    chart.legend.border_line_color = None
    return chart


def _add_waypoints(chart: figure, shown: Curves) -> None:
    places = shown.waypoints_m
    source = ColumnDataSource({"east": places[:, 1], "north": places[:, 0], "seq": list(shown.waypoint_seqs)})
    dots = chart.scatter("east", "north", source=source, size=5, color=PLANNED, legend_label="waypoints")
    chart.add_tools(HoverTool(renderers=[dots], tooltips="waypoint @seq: @north{0.0} m N, @east{0.0} m E"))
    named = apart(places)
    aside = beside(places)[named] * _LABEL_OFFSET_PX
    chart.text(
        places[named, 1],
        places[named, 0],
        text=[str(shown.waypoint_seqs[n]) for n in named],
        x_offset=aside[:, 1],
        y_offset=-aside[:, 0],
        text_align="center",
        text_baseline="middle",
        text_font_size="11px",
        text_color=PLANNED,
    )


def apart(places_m: Floats, share: float = LABEL_SHARE) -> list[int]:
    """Indices of places (n, 2) whose numbers do not cover each other; the first is always there."""
    least_m = share * float(np.ptp(places_m, axis=0).max())
    chosen: list[int] = []
    for n, place in enumerate(places_m):
        if not chosen or np.linalg.norm(places_m[chosen] - place, axis=1).min() >= max(least_m, 1e-9):
            chosen.append(n)
    return chosen


def beside(places_m: Floats) -> Floats:
    """Unit vectors (n, 2) to the left of the way through places (n, 2): where a number covers no line."""
    ahead, behind = np.vstack([places_m[1:], places_m[-1:]]), np.vstack([places_m[:1], places_m[:-1]])
    north, east = (ahead - behind).T
    length = np.hypot(north, east)
    left = np.column_stack([east, -north])
    return np.where(length[:, None] > 0, left / np.maximum(length, 1e-9)[:, None], [1.0, 0.0])


def time_chart(title: str, y_label: str, *, x_range: Range | None = None, height: int = 220) -> figure:
    """An empty chart over time; charts given the same ``x_range`` are zoomed together."""
    chart = figure(
        title=title,
        height=height,
        x_axis_label="time since the first fix / first waypoint (s)",
        y_axis_label=y_label,
        tools="pan,wheel_zoom,box_zoom,reset,save",
        sizing_mode="stretch_width",
        x_range=x_range if x_range is not None else DataRange1d(),
        y_range=DataRange1d(start=0) if "distance" in title else DataRange1d(),
    )
    chart.toolbar.logo = None
    return chart


def add_line(chart: figure, times_s: Sequence[float] | Floats, values: Floats, name: str) -> None:
    """A line over time in the colour of what it shows: "recorded", "planned" or "flown"."""
    colour = {"recorded": RECORDED, "planned": PLANNED, "flown": FLOWN}[name]
    width = 4 if name == "recorded" else 1.5
    line = chart.line(times_s, values, color=colour, width=width)
    chart.add_tools(HoverTool(renderers=[line], tooltips=f"{name} @y{{0.00}} at @x{{0.0}} s", mode="mouse"))
