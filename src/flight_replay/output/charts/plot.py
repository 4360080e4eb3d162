"""One page of plots of a replay: the paths to scale, errors, altitude and speed over time.

Lines differ in width and style as well as in colour.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.output.charts.series import (
    FLOWN_COLOUR,
    PLANNED_COLOUR,
    RECORDED_COLOUR,
    ErrorSeries,
    ReplaySeries,
    TrackSeries,
    replay_series,
)
from flight_replay.output.outcome import Outcome
from flight_replay.planning.route import Route
from flight_replay.supervisor.flight_plan import FlightRecord
from flight_replay.writing.output_files import check_suffix, write_atomically

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SUFFIXES = (".png", ".svg", ".pdf")
_PAGE_IN = (7.2, 9.4)
_PNG_DOTS_PER_IN = 150
_STYLE: dict[Any, Any] = {
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.grid": True,
    "grid.color": "0.9",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "pdf.fonttype": 42,
    "svg.hashsalt": "flight-replay",
}


def save_plot(
    path: Path | str, route: Route, record: FlightRecord | None = None, outcome: Outcome | None = None
) -> None:
    """Plot a route, and the flight that followed it if there was one, on one page.

    Raises:
        FlightReplayError: The suffix is not in ``SUFFIXES``, or the file cannot be written.
    """
    file_format = check_suffix(path, SUFFIXES).removeprefix(".")
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with rc_context(_STYLE):
        figure = Figure(figsize=_PAGE_IN, layout="constrained")
        FigureCanvasAgg(figure)
        _fill(figure, replay_series(route, record, outcome))
        page = io.BytesIO()
        dates = {"png": {}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}
        figure.savefig(page, format=file_format, dpi=_PNG_DOTS_PER_IN, metadata=dates[file_format])
    write_atomically(path, page.getvalue())


def _fill(figure: Figure, series: ReplaySeries) -> None:
    grid = figure.add_gridspec(3, 2, height_ratios=[2.6, 1, 1])
    _draw_map(figure.add_subplot(grid[0, :]), series)
    panels, cells = [_draw_path_error, _draw_altitude, _draw_speed], [grid[1, 0], grid[1, 1], grid[2, :]]
    if series.position_error is not None:
        panels.insert(1, _draw_position_error)
        cells[2:] = [grid[2, 0], grid[2, 1]]
    for cell, draw in zip(cells, panels, strict=True):
        axes = figure.add_subplot(cell, sharex=figure.axes[1] if len(figure.axes) > 1 else None)
        axes.set_xlabel("time since the first fix / first waypoint (s)")
        draw(axes, series)
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=5)
    # The length of a metre on the page is known only after the layout.
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    _draw_scale_and_north(figure.axes[0])


def _draw_map(axes: Axes, series: ReplaySeries) -> None:
    north_m, east_m = series.recorded.north_east_m.T
    axes.plot(east_m, north_m, color=RECORDED_COLOUR, linewidth=3, label="recorded", solid_capstyle="round")
    north_m, east_m = series.planned_m.T
    axes.plot(east_m, north_m, "--", color=PLANNED_COLOUR, linewidth=1.2, label="planned")
    if series.flown is not None:
        north_m, east_m = series.flown.north_east_m.T
        axes.plot(east_m, north_m, color=FLOWN_COLOUR, linewidth=1.2, label="flown")
    north_m, east_m = series.waypoints_m.T
    axes.plot(east_m, north_m, ".", color=PLANNED_COLOUR, ms=4, label="waypoints")
    axes.plot(east_m[0], north_m[0], "o", color="black", mfc="none", ms=8, label="first waypoint")
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.08)
    axes.set_xlabel("east of the first fix (m)")
    axes.set_ylabel("north of the first fix (m)")


def scale_bar_m(width_m: float) -> float:
    """Length of the scale bar: 1, 2 or 5 times a power of ten, at most a fifth of the map's width."""
    limit_m = width_m / 5
    power = 10.0 ** np.floor(np.log10(limit_m))
    return float(power * max(step for step in (1, 2, 5) if step * power <= limit_m))


def _draw_scale_and_north(axes: Axes) -> None:
    """A scale bar and a north arrow at the right of the map, outside the lines."""
    left, right = axes.get_xlim()
    length_m = scale_bar_m(right - left)
    share = length_m / (right - left)
    style: dict[str, Any] = {"transform": axes.transAxes, "color": "black", "clip_on": False}
    axes.plot(
        [0.985 - share, 0.985], [-0.075, -0.075], lw=2.5, solid_capstyle="butt", gid="scale-bar", **style
    )
    axes.text(0.985 - share / 2, -0.085, f"{length_m:g} m", ha="center", va="top", transform=axes.transAxes)
    arrow = {"arrowstyle": "-|>", "color": "black", "linewidth": 1.2}
    axes.annotate("", (0.985, 0.99), (0.985, 0.9), xycoords="axes fraction", arrowprops=arrow)
    axes.text(0.985, 0.995, "N", ha="center", va="bottom", weight="bold", transform=axes.transAxes)


def _draw_path_error(axes: Axes, series: ReplaySeries) -> None:
    _draw_error(axes, series.planned_error, PLANNED_COLOUR, "planned path error")
    if series.path_error is not None:
        _draw_error(axes, series.path_error, FLOWN_COLOUR, "path error")


def _draw_position_error(axes: Axes, series: ReplaySeries) -> None:
    if series.position_error is not None:
        _draw_error(axes, series.position_error, FLOWN_COLOUR, "position error")


def _draw_error(axes: Axes, error: ErrorSeries, colour: str, title: str) -> None:
    axes.plot(error.time_s, error.error_m, color=colour, linewidth=0.9)
    axes.set_ylabel("error (m)")
    total = error.statistics
    axes.set_title(f"{title}\nmean {total.mean:.2f} m, p95 {total.p95:.2f} m, max {total.max:.2f} m")


def _draw_altitude(axes: Axes, series: ReplaySeries) -> None:
    axes.set_title("altitude above home")
    axes.set_ylabel("altitude (m)")
    _draw_recorded_and_flown(axes, series, lambda track: track.alt_m)
    if series.reached:
        times_s, altitudes_m = zip(*series.reached, strict=True)
        axes.plot(times_s, altitudes_m, ".", color=PLANNED_COLOUR, ms=3)


def _draw_speed(axes: Axes, series: ReplaySeries) -> None:
    axes.set_title("ground speed")
    axes.set_ylabel("speed (m/s)")
    _draw_recorded_and_flown(axes, series, lambda track: track.speed_m_s)


def _draw_recorded_and_flown(
    axes: Axes, series: ReplaySeries, values: Callable[[TrackSeries], Floats]
) -> None:
    axes.plot(series.recorded.time_s, values(series.recorded), color=RECORDED_COLOUR, linewidth=2)
    if series.flown is not None:
        axes.plot(series.flown.time_s, values(series.flown), color=FLOWN_COLOUR, linewidth=0.9)
