"""How far from the recording the model of ArduCopter flies a route: its predicted errors."""

from __future__ import annotations

from dataclasses import replace

from flight_replay.errors import MissionError
from flight_replay.geometry.flight_errors import flight_errors
from flight_replay.geometry.movement import Movement
from flight_replay.planning.route import Route
from flight_replay.simulator.dynamics.limits import Limits

_STEP_S = 0.05
_ROWS_A_SAMPLE = 2  # Ten samples a second draw a path well enough.
_LONGEST_SIMULATED_M = 50_000.0


def with_prediction(route: Route, limits: Limits) -> Route:
    """The route with the errors that a vehicle of these limits will have.

    Without them where the model cannot fly the mission, or not in reasonable time.
    """
    if route.path.length_m > _LONGEST_SIMULATED_M:
        return route
    try:
        flown, last_s = _predicted_flight(route, limits)
    except MissionError:
        return route
    return replace(route, predicted=flight_errors(route.wanted, flown, last_s=last_s))


def _predicted_flight(route: Route, limits: Limits) -> tuple[Movement, float]:
    """The flight from when the first waypoint is reached, and when the last one is."""
    # The model of the whole vehicle takes as long to import as all else in a dry run.
    from flight_replay.simulator.flight.trajectory import home_frame, simulate

    flight = simulate(route.mission, limits, step_s=_STEP_S)
    seqs = [seq for seq, _ in route.mission.waypoints]
    first_s, last_s = flight.reached_s[seqs[0]], flight.reached_s[seqs[-1]]
    ground_m = route.frame.to_metres(*home_frame(route.mission).to_degrees(flight.north_east_m))
    whole = Movement(flight.time_s - first_s, ground_m, flight.up_m, flight.heading_deg)
    return whole.select(slice(None, None, _ROWS_A_SAMPLE)), last_s - first_s
