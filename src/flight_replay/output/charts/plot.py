"""One page of plots of a replay: the paths to scale, errors, altitude and speed over time.

Lines differ in width and style as well as in colour.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.output.charts.series import (
    FLOWN_COLOUR,
    LINE_COLOURS,
    PLANNED_COLOUR,
    PREDICTED_COLOUR,
    SMALLEST_RANGE,
    ErrorSeries,
    PathErrorSeries,
    ReplaySeries,
    TrackSeries,
    replay_series,
)
from flight_replay.output.outcome import Outcome
from flight_replay.output.result_text import statistics_text
from flight_replay.planning.route import Route
from flight_replay.writing.output_files import check_suffix, write_atomically

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SUFFIXES = (".png", ".svg", ".pdf")
_PAGE_IN = (7.2, 11.4)
_PNG_DOTS_PER_IN = 150
_MARGIN_SHARE = 0.05  # Above the highest line, also where there is one height only.
_SCALE_BAR_SHARE, _SCALE_BAR_IN = 0.075, 0.31
"""So far below the map is the scale bar, as a share of its height, at most: beside the name of its axis."""
_POINT_M = 0.01
"""A line that extends less than this, as of a flight straight up, is nowhere to be seen on a map."""
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


def save_plot(path: Path | str, route: Route, outcome: Outcome | None = None) -> None:
    """Plot a route, and the flight that followed it if there was one, on one page.

    Raises:
        FlightReplayError: The suffix is not in ``SUFFIXES``, or the file cannot be written.
    """
    file_format = check_suffix(path, SUFFIXES).removeprefix(".")
    from matplotlib import rc_context

    page = io.BytesIO()
    dates = {"png": {}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}
    figure = replay_figure(route, outcome)
    with rc_context(_STYLE):
        figure.savefig(page, format=file_format, dpi=_PNG_DOTS_PER_IN, metadata=dates[file_format])
    write_atomically(path, page.getvalue())


def replay_figure(route: Route, outcome: Outcome | None = None) -> Figure:
    """The page of plots of a route, and of the flight that followed it if there was one."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with rc_context(_STYLE):
        figure = Figure(figsize=_PAGE_IN, layout="constrained")
        FigureCanvasAgg(figure)
        _fill(figure, replay_series(route, outcome))
    return figure


def _fill(figure: Figure, series: ReplaySeries) -> None:
    errors = _error_panels(series)
    panels = [*errors, _draw_altitude, _draw_speed]
    rows = (len(panels) + 1) // 2
    grid = figure.add_gridspec(1 + rows, 2, height_ratios=[2.8] + [1] * rows)
    _draw_map(figure.add_subplot(grid[0, :]), series)
    for n, draw in enumerate(panels):
        alone = n == len(panels) - 1 and n % 2 == 0
        cell = grid[1 + n // 2, :] if alone else grid[1 + n // 2, n % 2]
        # The errors end where the flight did, altitude and speed are those of the whole recording.
        first = 0 if n < len(errors) else len(errors)
        axes = figure.add_subplot(cell, sharex=figure.axes[1 + first] if n > first else None)
        axes.set_xlabel(series.error_label if n < len(errors) else series.time_label)
        draw(axes, series)
        low, high = axes.get_ylim()
        axes.set_ylim(min(0.0, low), max(high, (1 + _MARGIN_SHARE) * float(axes.dataLim.y1), SMALLEST_RANGE))
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=6)
    # The length of a metre on the page is known only after the layout.
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    _draw_scale_and_north(figure.axes[0])


def _error_panels(series: ReplaySeries) -> list[Callable[[Axes, ReplaySeries], None]]:
    """What draws each of the errors that there are."""
    planned, shown = series.planned_error, series.shown_error
    path = shown.path or PathErrorSeries(None, None)
    panels = [
        ("path error, recorded to {}", planned.recorded_to_path, path.recorded_to_path, "m"),
        ("path error, {} to recorded", planned.path_to_recorded, path.path_to_recorded, "m"),
        ("position error", None, shown.position, "m"),
        ("height error", None, shown.height, "m"),
        ("heading error", None, shown.heading, "deg"),
    ]
    return [
        partial(_draw_error, title=_error_title(series, name, after), errors=(before, after), unit=unit)
        for name, before, after, unit in panels
        if before is not None or after is not None
    ]


def _error_title(series: ReplaySeries, name: str, flown: ErrorSeries | None) -> str:
    """The title of a panel whose numbers are those flown, or predicted, or else planned."""
    if flown is None:
        return f"planned {name.format('planned')}"
    return f"{'predicted ' if series.flown is None else ''}{name.format('flown')}"


def _draw_error(
    axes: Axes,
    series: ReplaySeries,
    *,
    title: str,
    errors: tuple[ErrorSeries | None, ErrorSeries | None],
    unit: str,
) -> None:
    """The error planned, thin, as far as was flown, and that flown, or predicted; numbers are the last's."""
    planned, flown = errors
    flown_colour = PREDICTED_COLOUR if series.flown is None else FLOWN_COLOUR
    end_s = np.inf if flown is None else flown.time_s[-1]
    for error, colour, width in ((planned, PLANNED_COLOUR, 0.7), (flown, flown_colour, 1.1)):
        if error is not None:
            shown = error.time_s <= end_s
            dot = _dot(error.time_s[shown])
            axes.plot(error.time_s[shown], error.error[shown], marker=dot, color=colour, linewidth=width)
            axes.set_title(f"{title}\n{statistics_text(error.statistics, unit)}")
    axes.set_ylabel(f"error ({unit})")
    low, high = axes.get_ylim()
    top = max(high, SMALLEST_RANGE)
    axes.set_ylim(max(low, -_MARGIN_SHARE * top), top)


def _dot(values: Floats) -> str:
    """The marker of a line through values (n,): a single one makes no line."""
    return "." if len(values) == 1 else ""


def _draw_map(axes: Axes, series: ReplaySeries) -> None:
    for name, track in series.recorded_lines:
        _draw_line(axes, track.north_east_m, name, 4, solid_capstyle="round")
    if series.predicted_unflown is not None:
        _draw_line(axes, series.predicted_unflown.north_east_m, "predicted", 2.2)
    north_m, east_m = series.planned_m.T
    axes.plot(east_m, north_m, "--", color=PLANNED_COLOUR, linewidth=1.2, label="planned")
    if series.flown is not None:
        _draw_line(axes, series.flown.north_east_m, "flown", 1.2)
    if series.waypoint_seqs:
        north_m, east_m = series.waypoints_m.T
        axes.plot(east_m, north_m, ".", color=PLANNED_COLOUR, ms=3, label="waypoints")
        axes.plot(east_m[0], north_m[0], "o", color="black", mfc="none", ms=8, label="first waypoint")
    axes.update_datalim(series.map_corners_m[:, ::-1])
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.08)
    axes.set_xlabel("east of the first fix (m)")
    axes.set_ylabel("north of the first fix (m)")


def _draw_line(axes: Axes, north_east_m: Floats, name: str, width: float, **style: Any) -> None:
    """Where somebody flew (n, 2), as a line, or as a dot of more than its width where it would be none."""
    is_point = len(north_east_m) > 0 and np.ptp(north_east_m, axis=0).max() < _POINT_M
    dot: dict[str, Any] = {"marker": "o", "markevery": [0], "ms": 2 * width} if is_point else {}
    north_m, east_m = north_east_m.T
    axes.plot(east_m, north_m, color=LINE_COLOURS[name], linewidth=width, label=name, **dot, **style)


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
    height_in = axes.get_window_extent().height / axes.figure.dpi
    low = min(_SCALE_BAR_SHARE, _SCALE_BAR_IN / height_in)
    style: dict[str, Any] = {"transform": axes.transAxes, "color": "black", "clip_on": False}
    axes.plot([0.985 - share, 0.985], [-low, -low], lw=2.5, solid_capstyle="butt", gid="scale-bar", **style)
    text: dict[str, Any] = {"ha": "right", "va": "center", "transform": axes.transAxes}
    axes.text(0.975 - share, -low, f"{length_m:g} m", **text)
    arrow = {"arrowstyle": "-|>", "color": "black", "linewidth": 1.2}
    axes.annotate("", (0.985, 0.99), (0.985, 0.9), xycoords="axes fraction", arrowprops=arrow)
    axes.text(0.985, 0.995, "N", ha="center", va="bottom", weight="bold", transform=axes.transAxes)


def _draw_altitude(axes: Axes, series: ReplaySeries) -> None:
    axes.set_title("altitude above home")
    axes.set_ylabel("altitude (m)")
    axes.plot(*series.planned_height, "--", color=PLANNED_COLOUR, linewidth=0.9, zorder=2.2)
    _draw_recorded_and_flown(axes, series, lambda track: track.alt_m)
    if series.reached:
        times_s, altitudes_m = zip(*series.reached, strict=True)
        axes.plot(times_s, altitudes_m, ".", color=PLANNED_COLOUR, ms=3, zorder=2.2)


def _draw_speed(axes: Axes, series: ReplaySeries) -> None:
    axes.set_title("ground speed")
    axes.set_ylabel("speed (m/s)")
    _draw_recorded_and_flown(axes, series, lambda track: track.speed_m_s)


def _draw_recorded_and_flown(
    axes: Axes, series: ReplaySeries, values: Callable[[TrackSeries], Floats]
) -> None:
    for name, track in series.timed_lines:
        dot = _dot(track.time_s)
        axes.plot(track.time_s, values(track), marker=dot, color=LINE_COLOURS[name], linewidth=2)
    for name, flight in (("predicted", series.predicted_unflown), ("flown", series.flown)):
        if flight is not None:
            axes.plot(flight.time_s, values(flight), color=LINE_COLOURS[name], linewidth=0.9, zorder=2.5)
