"""A route flown in the flight model alone: the record of a flight, without a link, a clock or a process."""

from __future__ import annotations

from operator import itemgetter

import numpy as np

from flight_replay.geometry.movement import Movement
from flight_replay.geometry.reference_motion import ReferenceMotion
from flight_replay.logs.track import Track, track_from_columns
from flight_replay.mission.items import Home, Mission
from flight_replay.planning.altitude import home_of
from flight_replay.planning.prediction import SAMPLE_S, step_for_s
from flight_replay.planning.route import Route
from flight_replay.simulator.flight.trajectory import Trajectory, home_frame, simulate
from flight_replay.supervisor.flight_plan import FlightRecord, FollowPlan


def fly_in_model(route: Route, *, duration_s: float | None, takeoff_m: float) -> FlightRecord:
    """Fly a route from where the take-off hands over, as ``supervisor.fly`` would on a perfect vehicle.

    Args:
        route: a mission, or a reference to follow in GUIDED, planned for the limits that are flown with.
        duration_s: time in AUTO, or of the recording that is followed; None for all of it.
        takeoff_m: take-off altitude above home, for a mission.

    Returns:
        The record; RTL is not flown.

    Raises:
        MissionError: The mission never ends, or has an item that cannot be simulated.
    """
    if route.reference is not None:
        return _followed(route, route.reference, duration_s)
    step_s = step_for_s(route)
    flight = simulate(route.mission, route.limits.limits, start_m=(0.0, 0.0, takeoff_m), step_s=step_s)
    begin_s, end_s, ended = _planned_end(route.mission, flight, duration_s)
    reached = sorted(
        ((seq, at_s) for seq, at_s in flight.reached_s.items() if at_s <= end_s), key=itemgetter(1)
    )
    waypoints = {seq for seq, _ in route.mission.waypoints}
    return _record(
        ended,
        begin_s,
        end_s,
        _flown(route, flight, end_s, round(SAMPLE_S / step_s)),
        reached=tuple(reached),
        waypoints_reached=len(waypoints & {seq for seq, _ in reached}),
    )


def _planned_end(mission: Mission, flight: Trajectory, duration_s: float | None) -> tuple[float, float, str]:
    """When AUTO begins and ends, and why it ends: as the supervisor decides it."""
    begin_s, done_s = flight.auto_s
    seqs = [seq for seq, _ in mission.waypoints]
    last_s = flight.reached_s.get(seqs[-1], done_s)
    if duration_s is None:
        return begin_s, last_s, "mission complete"
    heads_for_last_s = flight.reached_s.get(seqs[-2], last_s) if len(seqs) > 1 else begin_s
    if begin_s + duration_s <= heads_for_last_s:
        return begin_s, begin_s + duration_s, "duration"
    return begin_s, heads_for_last_s, "final waypoint"


def _flown(route: Route, flight: Trajectory, end_s: float, every: int) -> Track:
    """The positions up to the end, some a second."""
    lat_deg, lon_deg = home_frame(route.mission).to_degrees(flight.north_east_m)
    home: Home = route.mission.home or home_of(route.covered)
    velocity_m_s = np.column_stack([flight.north_m_s, flight.east_m_s, flight.up_m_s])
    track = track_from_columns(
        flight.time_s,
        lat_deg,
        lon_deg,
        flight.up_m,
        amsl_m=flight.up_m + home.amsl_m,
        velocity_m_s=velocity_m_s,
        heading_deg=flight.heading_deg,
    )
    shown = np.flatnonzero(flight.time_s <= end_s)
    return track.select(np.union1d(shown[::every], shown[-1:]))


def _followed(route: Route, reference: ReferenceMotion, duration_s: float | None) -> FlightRecord:
    # The libraries of following take longer to import than all else here.
    from flight_replay.planning.following.follow_prediction import predicted_following

    recorded_s = float(route.wanted.time_s[-1])
    plan = FollowPlan(reference=reference, recorded_s=recorded_s, duration_s=duration_s)
    flown = predicted_following(route, reference)
    flown = flown.select(flown.time_s <= plan.end_s)
    return _record(plan.ended, 0.0, plan.end_s, _track_of(route, flown), recording=flown)


def _track_of(route: Route, flown: Movement) -> Track:
    lat_deg, lon_deg = route.frame.to_degrees(flown.north_east_m)
    return track_from_columns(flown.time_s, lat_deg, lon_deg, flown.up_m, heading_deg=flown.heading_deg)


def _record(  # noqa: PLR0913
    ended: str,
    begin_s: float,
    end_s: float,
    flown: Track,
    *,
    reached: tuple[tuple[int, float], ...] = (),
    waypoints_reached: int = 0,
    recording: Movement | None = None,
) -> FlightRecord:
    return FlightRecord(
        waypoints_reached=waypoints_reached,
        ended=ended,
        problem=None,
        auto_start_s=begin_s,
        auto_s=end_s - begin_s,
        rtl_confirmed=False,
        landed=False,
        reached=reached,
        flown=flown,
        recording_s=None if recording is None else recording.time_s,
    )
