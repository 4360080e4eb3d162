"""Draw a stretch of the sample flight as the flight model replays it in three ways: docs/following.png.

python examples/draw_following.py [PICTURE.png]
"""

import sys

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from flight_replay.geometry.flight_errors import errors_at_equal_times
from flight_replay.geometry.movement import Movement
from flight_replay.logs.flights import select
from flight_replay.logs.read_log import read_log
from flight_replay.logs.sample import sample_log
from flight_replay.planning.altitude import RECORDED
from flight_replay.planning.fit import fit
from flight_replay.planning.following.follow_prediction import predicted_following
from flight_replay.planning.following.followed_route import FollowOptions, followed_route
from flight_replay.planning.prediction import predicted_flight
from flight_replay.planning.route import Route, route_of
from flight_replay.planning.spacing import spaced_route
from flight_replay.simulator.dynamics.limits import Limits

FROM_S, TO_S = 60.0, 165.0
ALTITUDE_M, MAX_POINTS = 30.0, 25
SHOWN_S = (39.0, 63.0)  # Of the stretch, on the map.
DOT_EVERY_S = 3.0
RECORDED_COLOUR = "0.6"
COLOURS = {"3 m rule": "#E69F00", "fitted mission": "#0072B2", "followed in GUIDED": "#D55E00"}


def mission_flight(route: Route) -> Movement:
    """A mission in the flight model, from when its first waypoint is reached until its last is."""
    flown, last_s, _ = predicted_flight(route, ALTITUDE_M)
    return flown.select((flown.time_s >= 0) & (flown.time_s <= last_s))


def flights() -> tuple[Movement, dict[str, Movement]]:
    """What was recorded, and the three ways to fly it again."""
    track = select(read_log(sample_log()).track, None, FROM_S, TO_S)
    spaced = spaced_route(track, altitude_m=ALTITUDE_M)
    found = fit(track, max_points=MAX_POINTS, altitude_m=ALTITUDE_M, speed_m_s=RECORDED)
    fitted = route_of("fit", found.mission, found.flown, heights=found.heights)
    followed = followed_route(track, np.full(len(track), ALTITUDE_M), Limits(), FollowOptions())
    assert followed.reference is not None
    in_step = predicted_following(followed, followed.reference)
    movements = (mission_flight(spaced), mission_flight(fitted), in_step)
    return followed.wanted, dict(zip(COLOURS, movements, strict=True))


def between(movement: Movement, begin_s: float, end_s: float) -> Movement:
    return movement.select((movement.time_s >= begin_s) & (movement.time_s <= end_s))


def draw_map(axes: Axes, recorded: Movement, flown: dict[str, Movement]) -> None:
    """The paths to scale; a dot for each vehicle at equal times, tied to the recorded one."""
    shown = between(recorded, *SHOWN_S)
    axes.plot(*shown.north_east_m.T[::-1], "-", color=RECORDED_COLOUR, linewidth=6, label="recorded")
    at_s = np.arange(SHOWN_S[0] + DOT_EVERY_S, SHOWN_S[1], DOT_EVERY_S)
    here = recorded.places_at(at_s)
    for name, movement in flown.items():
        path = between(movement, *SHOWN_S)
        axes.plot(*path.north_east_m.T[::-1], color=COLOURS[name], linewidth=1.4, label=name)
        there = movement.places_at(at_s)
        for a, b in zip(here, there, strict=True):
            axes.plot([a[1], b[1]], [a[0], b[0]], ":", color=COLOURS[name], linewidth=0.9)
        axes.plot(there[:, 1], there[:, 0], "o", color=COLOURS[name], markersize=4.5, zorder=4)
    axes.plot(here[:, 1], here[:, 0], "o", color="black", mfc="none", markersize=8, zorder=5)
    axes.set_aspect("equal")
    axes.margins(0.05)
    axes.set_xlabel("east (m)")
    axes.set_ylabel("north (m)")
    axes.set_title(f"{SHOWN_S[1] - SHOWN_S[0]:.0f} s from above; dots: all vehicles every {DOT_EVERY_S:g} s")


def draw_errors(axes: Axes, recorded: Movement, flown: dict[str, Movement]) -> None:
    """The position errors over time."""
    for name, movement in flown.items():
        error, _, _ = errors_at_equal_times(recorded, movement)
        axes.semilogy(error.time_s, np.maximum(error.error, 1e-2), color=COLOURS[name], linewidth=1.4)
    axes.axvspan(*SHOWN_S, color="0.93", zorder=0)
    axes.set_xlabel("time (s)")
    axes.set_ylabel("position error at equal times (m)")
    axes.set_ylim(0.01, 300)
    axes.grid(color="0.88", linewidth=0.6)
    axes.set_title("how far apart at equal times")


recorded, flown = flights()
figure = Figure(figsize=(11.0, 4.6), layout="constrained")
FigureCanvasAgg(figure)
map_axes, error_axes = figure.subplots(1, 2)
draw_map(map_axes, recorded, flown)
draw_errors(error_axes, recorded, flown)
figure.legend(*map_axes.get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
picture = sys.argv[1] if len(sys.argv) > 1 else "following.png"
try:
    figure.savefig(picture, dpi=130, metadata={"Software": None})
except (OSError, ValueError) as error:
    sys.exit(f"cannot write {picture}: {error}")
print(f"wrote {picture}")
