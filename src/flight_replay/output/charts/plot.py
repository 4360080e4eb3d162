"""One page of pictures of a replay: the paths to scale, the distances, altitude and speed over time.

Lines differ in width and style as well as in colour.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.output.charts.series import FLOWN, PLANNED, RECORDED, Curves, Distances, Flown, curves
from flight_replay.output.outcome import Outcome
from flight_replay.output_files import check_suffix, write_atomically
from flight_replay.planning.route import Route
from flight_replay.supervisor.flight_plan import FlightRecord

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
    """Draw a route, and the flight that followed it if there was one, on one page.

    Raises:
        FlightReplayError: The suffix is no picture's, or the file cannot be written.
    """
    file_format = check_suffix(path, SUFFIXES).removeprefix(".")
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with rc_context(_STYLE):
        figure = Figure(figsize=_PAGE_IN, layout="constrained")
        FigureCanvasAgg(figure)
        _fill(figure, curves(route, record, outcome))
        page = io.BytesIO()
        dates = {"png": {}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}
        figure.savefig(page, format=file_format, dpi=_PNG_DOTS_PER_IN, metadata=dates[file_format])
    write_atomically(path, page.getvalue())


def _fill(figure: Figure, shown: Curves) -> None:
    grid = figure.add_gridspec(3, 2, height_ratios=[2.6, 1, 1])
    _draw_map(figure.add_subplot(grid[0, :]), shown)
    panels, places = [_draw_in_space, _draw_altitude, _draw_speed], [grid[1, 0], grid[1, 1], grid[2, :]]
    if shown.in_time is not None:
        panels.insert(1, _draw_in_time)
        places[2:] = [grid[2, 0], grid[2, 1]]
    for place, draw in zip(places, panels, strict=True):
        axes = figure.add_subplot(place, sharex=figure.axes[1] if len(figure.axes) > 1 else None)
        axes.set_xlabel("time since the first fix / first waypoint (s)")
        draw(axes, shown)
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=5)
    # Only when everything has its place is a metre's length on the page known.
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    _draw_scale_and_north(figure.axes[0])


def _draw_map(axes: Axes, shown: Curves) -> None:
    north_m, east_m = shown.recorded.north_east_m.T
    axes.plot(east_m, north_m, color=RECORDED, linewidth=3, label="recorded", solid_capstyle="round")
    axes.plot(
        shown.planned_m[:, 1], shown.planned_m[:, 0], "--", color=PLANNED, linewidth=1.2, label="planned"
    )
    if shown.flown is not None:
        north_m, east_m = shown.flown.north_east_m.T
        axes.plot(east_m, north_m, color=FLOWN, linewidth=1.2, label="flown")
    axes.plot(shown.waypoints_m[:, 1], shown.waypoints_m[:, 0], ".", color=PLANNED, ms=4, label="waypoints")
    axes.plot(*shown.waypoints_m[0, ::-1], "o", color="black", mfc="none", ms=8, label="first waypoint")
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.08)
    axes.set_xlabel("east of the first fix (m)")
    axes.set_ylabel("north of the first fix (m)")


def scale_bar_m(width_m: float) -> float:
    """A round length (1, 2 or 5 and zeros) of about a fifth of a map's width."""
    wanted = width_m / 5
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(power * max(step for step in (1, 2, 5) if step * power <= wanted))


def _draw_scale_and_north(axes: Axes) -> None:
    """A scale bar and an arrow to north, below the map's right end where no line runs."""
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


def _draw_in_space(axes: Axes, shown: Curves) -> None:
    _draw_distance(axes, shown.planned_distance, PLANNED, "planned distance in space")
    if shown.in_space is not None:
        _draw_distance(axes, shown.in_space, FLOWN, "distance in space")


def _draw_in_time(axes: Axes, shown: Curves) -> None:
    if shown.in_time is not None:
        _draw_distance(axes, shown.in_time, FLOWN, "distance in time")


def _draw_distance(axes: Axes, over_time: Distances, colour: str, title: str) -> None:
    axes.plot(over_time.time_s, over_time.distance_m, color=colour, linewidth=0.9)
    axes.set_ylabel("from recorded (m)")
    of_all = over_time.spread
    axes.set_title(f"{title}\nmean {of_all.mean:.2f}, 95 % {of_all.p95:.2f}, max {of_all.max:.2f} m")


def _draw_altitude(axes: Axes, shown: Curves) -> None:
    axes.set_title("altitude above home")
    axes.set_ylabel("altitude (m)")
    _draw_both(axes, shown, lambda way: way.alt_m)
    if shown.reached:
        times_s, heights_m = zip(*shown.reached, strict=True)
        axes.plot(times_s, heights_m, ".", color=PLANNED, ms=3)


def _draw_speed(axes: Axes, shown: Curves) -> None:
    axes.set_title("ground speed")
    axes.set_ylabel("speed (m/s)")
    _draw_both(axes, shown, lambda way: way.speed_m_s)


def _draw_both(axes: Axes, shown: Curves, pick: Callable[[Flown], Floats]) -> None:
    axes.plot(shown.recorded.time_s, pick(shown.recorded), color=RECORDED, linewidth=2)
    if shown.flown is not None:
        axes.plot(shown.flown.time_s, pick(shown.flown), color=FLOWN, linewidth=0.9)
