"""Bokeh charts of a replay for the report and the live map: the paths to scale, and values over time.

Only those two import this module: importing Bokeh takes a third of a second.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from bokeh.core.properties import value
from bokeh.models import ColumnDataSource, DataRange1d, HoverTool, Range
from bokeh.models.annotations import Label, ScaleBar
from bokeh.models.annotations.dimensional import Metric
from bokeh.models.renderers import GlyphRenderer
from bokeh.plotting import figure

from flight_replay.geometry.arrays import Floats
from flight_replay.output.charts.series import (
    LINE_COLOURS,
    PLANNED_COLOUR,
    PREDICTED_COLOUR,
    SMALLEST_MAP_M,
    ReplaySeries,
)

TOOLS = "pan,wheel_zoom,box_zoom,reset,save"
LABEL_GAP_SHARE = 0.14
"""Least distance between two waypoint numbers, as a share of the map's longer side."""
_TIME_CHART_HEIGHT = 220
_MARGIN_SHARE = 0.16  # Waypoint numbers stand outside the path, on narrow screens too.
_LABEL_OFFSET_PX = 13
_LEGEND_COLUMNS = 2  # More do not fit a telephone.
_LEGEND_GAP_PX = 10
_HOME_PX = 17
_DOT_PX = 7
_LINE_WIDTHS = {"recorded": 4.0, "recorded, not covered": 4.0, "predicted": 2.5}
"""Those of lines that are drawn below others, which they must not be hidden by."""


def map_chart(series: ReplaySeries, *, height: int = 460) -> figure:
    """The recorded and the planned path to scale, north up, with home, and waypoints by their numbers.

    What is not covered of the recording is paler. The predicted path is there until there is a flown one.
    The place of home is the data source named "home".
    """
    chart = figure(
        height=height,
        match_aspect=True,
        x_axis_label="east of the first fix (m)",
        y_axis_label="north of the first fix (m)",
        tools=TOOLS,
        active_scroll="wheel_zoom",
        sizing_mode="stretch_width",
        x_range=DataRange1d(range_padding=_MARGIN_SHARE),
        y_range=DataRange1d(range_padding=_MARGIN_SHARE),
    )
    chart.toolbar.logo = None
    chart.scatter(*series.map_corners_m.T[::-1], alpha=0.0, name="corners")
    for name, track in series.recorded_lines:
        north_m, east_m = track.north_east_m.T
        chart.line(east_m, north_m, color=LINE_COLOURS[name], line_width=5, legend_label=name)
    if series.predicted_unflown is not None:
        north_m, east_m = series.predicted_unflown.north_east_m.T
        chart.line(east_m, north_m, color=PREDICTED_COLOUR, line_width=3, legend_label="predicted")
    north_m, east_m = series.planned_m.T
    chart.line(
        east_m, north_m, color=PLANNED_COLOUR, line_width=1.5, line_dash="dashed", legend_label="planned"
    )
    if series.waypoint_seqs:
        _add_waypoints(chart, series)
    _add_home(chart, series.home_m)
    _add_scale_and_north(chart)
    chart.legend.orientation = "horizontal"
    chart.legend.ncols = _LEGEND_COLUMNS
    chart.add_layout(chart.legend[0], "above")
    chart.legend.border_line_color = None
    chart.legend.spacing = _LEGEND_GAP_PX
    return chart


def _add_home(chart: figure, home_m: Floats | None) -> None:
    """Home, above the flown lines that are added later."""
    place = [] if home_m is None else [home_m]
    source = ColumnDataSource(
        {"east": [float(each[1]) for each in place], "north": [float(each[0]) for each in place]}, name="home"
    )
    chart.scatter(
        "east", "north", source=source, size=_HOME_PX, fill_color="white", line_color="black",
        legend_label="home (launch)", level="annotation",
    )  # fmt: skip
    chart.text(
        "east", "north", text=value("H"), source=source, text_align="center", text_baseline="middle",
        text_font_size="11px", text_font_style="bold", level="annotation",
    )  # fmt: skip


def _add_scale_and_north(chart: figure) -> None:
    """A scale bar, and an arrow to the north, in the map's lower corners."""
    chart.add_layout(
        ScaleBar(
            range=chart.x_range, unit="m", dimensional=Metric(base_unit="m"), location="bottom_right",
            background_fill_alpha=0.7, border_line_color=None, padding=4, margin=6,
        )
    )  # fmt: skip
    chart.add_layout(
        Label(
            x=14, y=8, x_units="screen", y_units="screen", text="N\n\N{UPWARDS ARROW}", text_align="center",
            text_font_size="15px", text_font_style="bold", text_line_height=0.9,
        )
    )  # fmt: skip


def _add_waypoints(chart: figure, series: ReplaySeries) -> None:
    points_m = series.waypoints_m
    source = ColumnDataSource(
        {
            "east": points_m[:, 1],
            "north": points_m[:, 0],
            "seq": list(series.waypoint_seqs),
            "number": list(range(1, len(points_m) + 1)),
        }
    )
    dots = chart.scatter(
        "east", "north", source=source, size=5, color=PLANNED_COLOUR, legend_label="waypoints"
    )
    chart.add_tools(
        HoverTool(renderers=[dots], tooltips="waypoint @number (item @seq): @north{0.0} m N, @east{0.0} m E")
    )
    labelled = label_indices(points_m)
    offsets_px = left_of_path(points_m)[labelled] * _LABEL_OFFSET_PX
    chart.text(
        points_m[labelled, 1],
        points_m[labelled, 0],
        text=[str(n + 1) for n in labelled],
        x_offset=offsets_px[:, 1],
        y_offset=-offsets_px[:, 0],
        text_align="center",
        text_baseline="middle",
        text_font_size="11px",
        text_color=PLANNED_COLOUR,
    )


def label_indices(points_m: Floats) -> list[int]:
    """Indices of the points (n, 2) to label so that no two labels overlap; the first is always included."""
    gap_m = LABEL_GAP_SHARE * max(float(np.ptp(points_m, axis=0).max()), SMALLEST_MAP_M)
    chosen: list[int] = []
    for n, point in enumerate(points_m):
        if not chosen or np.linalg.norm(points_m[chosen] - point, axis=1).min() >= gap_m:
            chosen.append(n)
    return chosen


def left_of_path(points_m: Floats) -> Floats:
    """Unit vectors (n, 2) to the left of the path through points (n, 2); north where it does not move."""
    ahead, behind = np.vstack([points_m[1:], points_m[-1:]]), np.vstack([points_m[:1], points_m[:-1]])
    north, east = (ahead - behind).T
    length = np.hypot(north, east)
    left = np.column_stack([east, -north])
    return np.where(length[:, None] > 0, left / np.maximum(length, 1e-9)[:, None], [1.0, 0.0])


def time_chart(title: str, x_label: str, y_label: str, *, x_range: Range | None = None) -> figure:
    """An empty chart over time; charts that are given the same ``x_range`` zoom together."""
    chart = figure(
        title=title,
        height=_TIME_CHART_HEIGHT,
        x_axis_label=x_label,
        y_axis_label=y_label,
        tools=TOOLS,
        sizing_mode="stretch_width",
        x_range=x_range if x_range is not None else DataRange1d(),
        y_range=DataRange1d(start=0) if "error" in title else DataRange1d(),
    )
    chart.toolbar.logo = None
    return chart


def add_line(chart: figure, times_s: Sequence[float] | Floats, values: Floats, name: str) -> None:
    """A line over time in the colour of its name, such as "planned" or "flown"; a dot for a single value."""
    colour = LINE_COLOURS[name]
    line: GlyphRenderer[Any]
    if len(values) == 1:
        line = chart.scatter(times_s, values, color=colour, size=_DOT_PX, name=name)
    else:
        line = chart.line(times_s, values, color=colour, line_width=_LINE_WIDTHS.get(name, 1.5), name=name)
    chart.add_tools(HoverTool(renderers=[line], tooltips=f"{name} @y{{0.00}} at @x{{0.0}} s", mode="mouse"))
