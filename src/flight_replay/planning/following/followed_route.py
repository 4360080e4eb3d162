"""The route of a recording that is followed in step: its reference, and what is to be said of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import tan

import numpy as np

from flight_replay.exceptions import MissionError
from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.geometry.flight_errors import Errors, path_errors
from flight_replay.geometry.movement import Movement
from flight_replay.geometry.reference_motion import ReferenceMotion, Thrust
from flight_replay.logs.track import Track
from flight_replay.mission.items import FIRST_SEQ, Mission, waypoint
from flight_replay.mission.path import Path
from flight_replay.planning.altitude import FLOOR_M, home_of
from flight_replay.planning.drag import Drag, DragModel, sitl_drag
from flight_replay.planning.flown_part import flown_fixes, flown_part
from flight_replay.planning.following.controller_lag import acceleration_lag, drag_lag
from flight_replay.planning.following.follow_notes import follow_notes, slower
from flight_replay.planning.following.reference_planner import RecordedMotion, ReferenceBounds, plan_reference
from flight_replay.planning.following.samples import Bridge, times_with_bridges
from flight_replay.planning.route import Route
from flight_replay.planning.vehicle_limits import VehicleLimits
from flight_replay.simulator.dynamics.limits import GRAVITY_M_S2, Limits
from flight_replay.supervisor.follower import DEFAULT_TUNING, Tuning

OUTLINE_STEP_S = 1.0
"""The most time between two places of a route's outline."""
_PATH_STEP_S = 0.1
_FARTHEST_M = 20.0
"""So far beside the recording there may be what the recorded vehicle flew around."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FollowOptions:
    """How to follow: ``pace`` times as fast as recorded, with the recorded headings or without.

    ``floor_m`` above home is the lowest that is flown; ``approach_m_s`` is the speed of the way to the
    first fix. ``drag`` is the vehicle's own, where it tells it.
    """

    pace: float = 1.0
    headings: bool = True
    floor_m: float = FLOOR_M
    approach_m_s: float = 10.0
    drag: DragModel | None = None


def followed_route(track: Track, heights_m: Floats, limits: Limits, options: FollowOptions) -> Route:
    """The route of a track that is followed in GUIDED.

    Args:
        track: what to follow; its flown part is.
        heights_m: metres above home to fly at each fix (n,).
        limits: of the vehicle.
        options: how to follow.

    Raises:
        MissionError: no motion within the limits follows the track, or only one that leads far beside it.
    """
    recorded, notes = flown_part(track, tell_joins=False)  # The bridges tell of them.
    commanded = replace(recorded, alt_m=heights_m[flown_fixes(track)])
    motion, bridges = _motion(commanded, options.pace, limits.wp_speed_m_s)
    floor_m = min(options.floor_m, float(heights_m.min()))
    reference = _reference(motion, limits, options, floor_m, home_of(recorded).alt_amsl_m or 0.0)
    wanted = _wanted(motion.time_s, recorded, commanded.alt_m)
    path = _path(reference, recorded, float(motion.time_s[-1]))
    planned_error = path_errors(wanted, path.north_east_m)
    _check_beside(planned_error.path_to_recorded, options.pace)
    return Route(
        method="guided",
        mission=_outline(reference, recorded),
        covered=recorded,
        recorded=recorded,
        wanted=wanted,
        planned_up_m=reference.positions_m(motion.time_s)[:, 2],
        recording=recorded,
        path=path,
        planned_error=planned_error,
        predicted_duration_s=float(motion.time_s[-1]) - reference.begin_s,
        reference=reference,
        pace=options.pace,
        limits=VehicleLimits(limits),
        notes=(
            *notes,
            *follow_notes(motion, reference, bridges, approach_m_s=options.approach_m_s, pace=options.pace),
        ),
    )


def _check_beside(errors: Errors, pace: float) -> None:
    """Refuse a way that leads far beside the recording, as a vehicle's that is too slow for it cuts bends."""
    worst = int(np.argmax(errors.error))
    beside_m, at_s = float(errors.error[worst]), float(errors.time_s[worst])
    if beside_m > _FARTHEST_M:
        raise MissionError(
            f"the vehicle is too slow for the recording: its way would lead {beside_m:.0f} m beside it, "
            f"at {at_s:.0f} s; {slower(pace)}"
        )


def _reference(
    motion: RecordedMotion, limits: Limits, options: FollowOptions, floor_m: float, amsl_m: float
) -> ReferenceMotion:
    """The reference of a recorded motion, with what drag at an altitude takes, and the lag that it makes."""
    reference = plan_reference(
        motion,
        ReferenceBounds.of(limits),
        _drag(options, amsl_m),
        headings=options.headings,
        floor_m=floor_m,
    )
    drag = sitl_drag(amsl_m)
    return replace(reference, drag_lag=drag_lag(reference, drag, limits), thrust=thrust_of(drag, limits))


def thrust_of(drag: Drag, limits: Limits) -> Thrust:
    """What a vehicle of these limits has, and how much of it a drag takes."""
    return Thrust(GRAVITY_M_S2 * tan(limits.lean_angle_rad), drag.linear_per_s, drag.square_per_m)


def reference_for(reference: ReferenceMotion, route: Route, tuning: Tuning) -> ReferenceMotion:
    """The reference of a route, with the lags of a vehicle's firmware; as planned, they are 4.6's.

    Args:
        reference: the route's.
        route: a followed one; its limits have the gains of the vehicle's controllers.
        tuning: of its firmware.
    """
    if tuning.feed_forward == DEFAULT_TUNING.feed_forward:
        return reference
    limits, per_s = route.limits.limits, tuning.drag_per_s
    drag = sitl_drag(home_of(route.covered).alt_amsl_m or 0.0) if per_s is None else Drag(per_s, 0.0)
    return replace(
        reference,
        drag_lag=drag_lag(reference, drag, limits, tuning),
        thrust=thrust_of(drag, limits),
        acceleration_lag=acceleration_lag(reference, limits, tuning),
    )


def _drag(options: FollowOptions, amsl_m: float) -> Drag:
    """The vehicle's own drag, or that of SITL's quadcopter where it does not tell it."""
    return sitl_drag(amsl_m) if options.drag is None else options.drag.at(amsl_m)


def _motion(recorded: Track, pace: float, speed_m_s: float) -> tuple[RecordedMotion, tuple[Bridge, ...]]:
    """The recorded motion on the clock that it is followed by, and the jumps that need more time."""
    frame = FlatFrame(float(recorded.lat_deg[0]), float(recorded.lon_deg[0]))
    places_m = frame.to_metres(recorded.lat_deg, recorded.lon_deg)
    times_s, bridges = times_with_bridges(recorded.time_s, places_m, speed_m_s, pace)
    position_m = np.column_stack([places_m, recorded.alt_m])
    return RecordedMotion(frame, times_s, position_m, recorded.heading_deg), bridges


def _wanted(times_s: Floats, recorded: Track, up_m: Floats) -> Movement:
    """What a flight is measured with: the recorded places and headings, on the clock that is followed."""
    return Movement(times_s, recorded.north_east_m(recorded.frame), up_m, recorded.heading_deg)


def _path(reference: ReferenceMotion, track: Track, recorded_s: float) -> Path:
    """The line that the reference draws while the recording lasts."""
    times_s = np.linspace(0.0, recorded_s, max(int(np.ceil(recorded_s / _PATH_STEP_S)), 1) + 1)
    places_m = reference.positions_m(times_s)
    ground_m = track.frame.to_metres(*reference.frame.to_degrees(places_m[:, :2]))
    return Path(ground_m, places_m[:, 2], np.full(len(times_s), FIRST_SEQ, np.intp))


def _outline(reference: ReferenceMotion, track: Track) -> Mission:
    """Waypoints every second of the reference, for fences, maps and files; they are not uploaded."""
    places_m = reference.positions_m(reference.times_s(OUTLINE_STEP_S))
    lat_deg, lon_deg = reference.frame.to_degrees(places_m[:, :2])
    items = tuple(
        waypoint(float(lat), float(lon), float(up))
        for lat, lon, up in zip(lat_deg, lon_deg, places_m[:, 2], strict=True)
    )
    return Mission(items, home_of(track))
