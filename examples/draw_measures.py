"""Draw what the measures measure, on a sharp turn that the flight model flies: docs/measures.png.

python examples/draw_measures.py [PICTURE.png]
"""

import sys

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.flight_errors import spaced_places_m
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.geometry.matching import match_in_order
from flight_replay.geometry.movement import Movement
from flight_replay.geometry.polyline import lengths_along_m
from flight_replay.mission.items import Home, Mission, waypoint
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.trajectory import simulate

FRAME = LocalFrame(47.0, 8.0)
CORNERS_M = np.array([[0.0, 0.0], [0.0, 30.0], [20.0, 8.0]])
WAYPOINTS_M = np.array([[0.0, 0.0], [0.0, 22.7], [0.0, 30.0], [4.65, 24.9], [20.0, 8.0]])
SPLINE = (False, True, True, False, False)
SPEED_M_S, FIX_EVERY_S = 4.0, 0.75
EVERY_PLACE = 3  # One of so many places is drawn.
AT_S = (4.0, 8.5, 14.0)
RECORDED, FLOWN, ERROR = "0.6", "#D55E00", "#0072B2"


def recorded() -> Movement:
    """Fixes of a sharp turn at constant speed."""
    along = lengths_along_m(CORNERS_M)
    end_s = along[-1] / SPEED_M_S
    time_s = np.append(np.arange(0.0, end_s, FIX_EVERY_S), end_s)
    places = np.column_stack([np.interp(time_s * SPEED_M_S, along, axis) for axis in CORNERS_M.T])
    unknown = np.full(len(time_s), np.nan)
    return Movement(time_s, places, unknown, unknown)


def flown() -> Movement:
    """Waypoints on the way, two of them splines, as ArduCopter flies them: past the turn, and back."""
    places = zip(*FRAME.to_degrees(WAYPOINTS_M), SPLINE, strict=True)
    items = tuple(waypoint(float(lat), float(lon), 30.0, spline=spline) for lat, lon, spline in places)
    flight = simulate(Mission(items, Home(FRAME.lat_deg, FRAME.lon_deg, 0.0)), Limits())
    time_s = flight.time_s - flight.reached_s[1]
    whole = Movement(time_s, flight.north_east_m, flight.up_m, flight.heading_deg)
    return whole.select((time_s >= 0) & (time_s <= flight.reached_s[len(items)] - flight.reached_s[1]))


def draw_paths(axes: Axes, record: Movement, flight: Movement, title: str) -> None:
    """The recorded fixes and the flown path, to scale."""
    north, east = record.north_east_m.T
    axes.plot(east, north, "o-", color=RECORDED, linewidth=3, markersize=5, label="recorded fixes")
    north, east = flight.north_east_m.T
    axes.plot(east, north, color=FLOWN, linewidth=1.6, label="flown path")
    axes.set_title(title, fontsize=10)
    axes.set_aspect("equal")
    axes.set_axis_off()


def draw_errors(axes: Axes, from_m: Floats, to_m: Floats) -> None:
    """A line from each place to the one that it is matched to; the longest has its length beside it."""
    matched = match_in_order(from_m, to_m)
    along = lengths_along_m(to_m)
    feet = np.column_stack([np.interp(matched.along_m, along, axis) for axis in to_m.T])
    lines = np.stack([from_m, feet], axis=1)[:, :, ::-1]
    axes.add_collection(LineCollection(list(lines), colors=ERROR, linewidths=1.1, label="error", zorder=4))
    worst = int(np.argmax(matched.distance_m))
    axes.plot(*lines[worst].T, color=ERROR, linewidth=2.6, zorder=4)
    draw_length(axes, lines[worst], float(matched.distance_m[worst]), "max ")


def draw_equal_times(axes: Axes, record: Movement, flight: Movement) -> None:
    """Both vehicles at some times."""
    here, there = record.places_at(np.array(AT_S)), flight.places_at(np.array(AT_S))
    for second, a, b in zip(AT_S, here[:, ::-1], there[:, ::-1], strict=True):
        line = np.stack([a, b])
        axes.plot(*line.T, color=ERROR, linewidth=1.6, zorder=4)
        axes.plot(*a, "o", color="0.25", markersize=8, zorder=5)
        axes.plot(*b, "o", color=FLOWN, markeredgecolor="black", markersize=8, zorder=5)
        draw_length(axes, line, float(np.linalg.norm(a - b)), f"at {second:g} s: ")


def draw_length(axes: Axes, line: Floats, length_m: float, text: str) -> None:
    """How long an error is, beside its middle."""
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.5}
    x, y = line.mean(axis=0).tolist()
    axes.annotate(
        f"{text}{length_m:.1f} m", (x, y), (0, 16), textcoords="offset points",
        ha="center", color=ERROR, fontsize=9, bbox=box, zorder=6,
    )  # fmt: skip


record, flight = recorded(), flown()
figure = Figure(figsize=(10.5, 3.7), layout="constrained")
FigureCanvasAgg(figure)
fixes_axes, path_axes, time_axes = figure.subplots(1, 3, sharex=True, sharey=True)
draw_paths(fixes_axes, record, flight, "path error, recorded to flown:\nfrom each fix to the flown path")
draw_errors(fixes_axes, record.north_east_m, flight.north_east_m)
draw_paths(
    path_axes, record, flight, "path error, flown to recorded:\nfrom the flown path to the recorded line"
)
draw_errors(path_axes, spaced_places_m(flight.north_east_m)[::EVERY_PLACE], record.north_east_m)
draw_paths(time_axes, record, flight, "position error:\nboth vehicles at equal times")
draw_equal_times(time_axes, record, flight)
figure.legend(*fixes_axes.get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
picture = sys.argv[1] if len(sys.argv) > 1 else "measures.png"
try:
    figure.savefig(picture, dpi=130, metadata={"Software": None})
except (OSError, ValueError) as error:
    sys.exit(f"cannot write {picture}: {error}")
print(f"wrote {picture}")
