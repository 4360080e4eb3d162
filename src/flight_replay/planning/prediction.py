"""How far from the recording the model of ArduCopter flies a route: its predicted errors."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flight_replay.exceptions import MissionError
from flight_replay.geometry.flight_errors import flight_errors
from flight_replay.geometry.movement import Movement
from flight_replay.mission.items import Command
from flight_replay.planning.dives import dive_note
from flight_replay.planning.duration import LONGEST_SIMULATED_M
from flight_replay.planning.route import Route

if TYPE_CHECKING:
    from flight_replay.simulator.flight.trajectory import Trajectory

_STEP_S, _LONG_STEP_S = 0.005, 0.05
_CURVED = (Command.SPLINE_WAYPOINT, Command.CONDITION_YAW)
"""In long steps each turn of a chain ends some hundredths of a second too soon, and the next ones with it."""
_LONG_M = 5_000.0
"""Beyond this, the tenths of a second at splines' sharp turns that long steps miss are not worth the wait."""
SAMPLE_S = 0.1  # Ten samples a second draw a path well enough.
_ERROR = (
    "ArduCopter reports an internal error on a short straight leg of this mission, and does not arm again "
    "before a reboot; plan it otherwise, such as with another --spacing or --max-points."
)


def with_prediction(route: Route, takeoff_m: float) -> Route:
    """The route with the errors that a vehicle of its limits will have, and its time in AUTO.

    Without errors where the model cannot fly the mission, or not in reasonable time.

    Args:
        route: at least one waypoint.
        takeoff_m: take-off altitude above home.
    """
    climb_m = abs(route.mission.waypoints[0][1].alt_m - takeoff_m)
    if route.path.length_m + climb_m > LONGEST_SIMULATED_M:
        return route
    try:
        flown, last_s, flight = predicted_flight(route, takeoff_m)
    except MissionError:
        return route
    begin_s, end_s = flight.auto_s
    predicted = replace(
        route,
        predicted=flight_errors(route.wanted, flown, last_s=last_s),
        predicted_flight=flown,
        predicted_duration_s=end_s - begin_s,
    )
    return predicted.with_notes(_ERROR if flight.has_error else "", dive_note(flown, route.limits.limits))


def step_for_s(route: Route) -> float:
    """How long the model's steps are for a route: long where nothing turns on legs, or the path is long."""
    is_curved = any(item.command in _CURVED for item in route.mission.items)
    return _STEP_S if is_curved and route.path.length_m <= _LONG_M else _LONG_STEP_S


def predicted_flight(route: Route, takeoff_m: float) -> tuple[Movement, float, Trajectory]:
    """The flight from when the first waypoint is reached, when the last one is, and the whole trajectory."""
    # The model of the whole vehicle takes as long to import as all else in a dry run.
    from flight_replay.simulator.flight.trajectory import home_frame, simulate

    step_s = step_for_s(route)
    flight = simulate(route.mission, route.limits.limits, start_m=(0.0, 0.0, takeoff_m), step_s=step_s)
    seqs = [seq for seq, _ in route.mission.waypoints]
    first_s, last_s = flight.reached_s[seqs[0]], flight.reached_s[seqs[-1]]
    ground_m = route.frame.to_metres(*home_frame(route.mission).to_degrees(flight.north_east_m))
    whole = Movement(flight.time_s - first_s, ground_m, flight.up_m, flight.heading_deg)
    every = round(SAMPLE_S / step_s)
    return whole.select(slice(None, None, every)), last_s - first_s, flight
