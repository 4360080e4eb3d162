"""The ``--json`` object, which other programs read: its keys and units do not change.

Lengths in metres, times in seconds, angles in degrees, unless the key says otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from flight_replay.mission.items import FIRST_SEQ, MissionItem

if TYPE_CHECKING:
    from flight_replay.geometry.error_statistics import ErrorStatistics
    from flight_replay.geometry.flight_errors import FlightErrors, PathErrors
    from flight_replay.geometry.reference_motion import ReferenceMotion
    from flight_replay.logs.flights import Flight
    from flight_replay.logs.recording import Recording
    from flight_replay.output.outcome import Outcome
    from flight_replay.planning.heights import HeightChange, RouteHeights
    from flight_replay.planning.route import Route
    from flight_replay.planning.vehicle_limits import VehicleLimits

Json = Mapping[str, Any]

_REFERENCE_STEP_S = 0.1


def log_summary(log: Recording, flights: Sequence[Flight]) -> Json:
    """The "log" object; ``fixes`` counts the usable fixes of the chosen vehicle.

    A log that is not ``timed`` was recorded without times: where its flights begin and end is null.
    """
    return {
        "path": log.path,
        "format": log.format,
        "bytes": log.bytes,
        "firmware": log.firmware,
        "vehicle_type": log.vehicle_type,
        "start_utc_s": log.start_utc_s,
        "boots": int(np.ptp(log.track.boot)) + 1,
        "timed": log.track.timed,
        "fixes": len(log.track),
        "without_position": log.without_position,
        "rejected": log.rejected_total,
        "rejected_by_reason": dict(log.rejected),
        "vehicles": [
            {"system": each.system, "component": each.component, "fixes": each.fixes} for each in log.vehicles
        ],
        "flights": [
            {
                "number": flight.number,
                "start_s": _rounded(flight.start_s if log.track.timed else None),
                "end_s": _rounded(flight.end_s if log.track.timed else None),
                "fixes": flight.fixes,
                "length_m": _rounded(flight.length_m),
                "highest_m": _rounded(flight.highest_m),
                "top_speed_m_s": _rounded(flight.top_speed_m_s),
            }
            for flight in flights
        ],
        "notes": list(log.notes),
    }


def _rounded(value: float | None, digits: int = 3) -> float | None:
    """A value to the thousandth, or to so many digits; never -0.0."""
    return None if value is None else round(value, digits) + 0.0


def route_summary(route: Route) -> Json:
    """The "route" object; its items do not include home."""
    objective = {} if route.objective_m is None else {"objective_m": _rounded(route.objective_m, 4)}
    return {
        "method": route.method,
        **_what_is_flown(route),
        "fixes_covered": len(route.recorded),
        "length_m": _rounded(route.path.length_m),
        "planned_error_m": _both_ways(route.planned_error, "planned"),
        **objective,
        "limits": _limits(route.limits),
        "heights": None if route.heights is None else _heights(route.heights),
        "predicted": None if route.predicted is None else errors_summary(route.predicted),
        "predicted_duration_s": _rounded(route.predicted_duration_s),
    }


def _what_is_flown(route: Route) -> Json:
    """The mission, or the reference that is followed in GUIDED."""
    if route.reference is None:
        return {
            "points": len(route.mission.waypoints),
            "items": [_item(seq, item) for seq, item in enumerate(route.mission.items, FIRST_SEQ)],
        }
    return {"points": 0, "items": [], "reference": reference_summary(route.reference)}


def reference_summary(reference: ReferenceMotion) -> Json:
    """How long, fast, hard and low a reference flies."""
    times_s = reference.times_s(_REFERENCE_STEP_S)
    velocity, acceleration = reference.velocities_m_s(times_s), reference.accelerations_m_s2(times_s)
    return {
        "duration_s": _rounded(reference.end_s - reference.begin_s),
        "top_speed_m_s": _rounded(float(np.hypot(*velocity[:, :2].T).max())),
        "top_climb_m_s": _rounded(float(velocity[:, 2].max())),
        "top_descent_m_s": _rounded(float(-velocity[:, 2].min())),
        "top_acceleration_m_s2": _rounded(float(np.linalg.norm(acceleration, axis=1).max())),
        "lowest_m": _rounded(float(reference.positions_m(times_s)[:, 2].min())),
        "highest_m": _rounded(float(reference.positions_m(times_s)[:, 2].max())),
    }


def flight_summary(vehicle: str, simulated: bool, outcome: Outcome) -> Json:
    """The "flight" object."""
    record = outcome.record
    return {
        "vehicle": vehicle,
        "simulated": simulated,
        "waypoints_reached": record.waypoints_reached,
        "ended": record.ended,
        "auto_s": _rounded(record.auto_s),
        "rtl_confirmed": record.rtl_confirmed,
        "coverage": _coverage(outcome),
        **errors_summary(outcome.errors),
        "alignment": _alignment(outcome),
        "not_measured": dict(outcome.not_measured),
    }


def _coverage(outcome: Outcome) -> Json:
    """Which part of the recorded flight was flown again, and the options that fly all of it."""
    coverage = outcome.coverage
    return {
        "fixes": coverage.fixes,
        "of_fixes": coverage.of_fixes,
        "recorded_s": _rounded(coverage.recorded_s if coverage.timed else None),
        "of_recorded_s": _rounded(coverage.of_recorded_s if coverage.timed else None),
        "to_fly_all": list(coverage.fly_all),
    }


def _alignment(outcome: Outcome) -> Json:
    """What the errors at equal times put on what, and for how many fixes there are such errors.

    ``flown_s`` of the vehicle's clock is put on ``recorded_s`` seconds since the first flown fix;
    ``waited_s`` is how long a recording that is followed waited for the vehicle.
    """
    errors = outcome.errors
    first_s = outcome.first_waypoint_s
    return {
        "recorded_s": 0.0,
        "flown_s": _rounded(first_s),
        "waited_s": _rounded(outcome.waited_s),
        "seconds": _rounded(float(np.ptp(errors.position_m.time_s))) if len(errors.position_m) else 0.0,
        "fixes": len(errors.position_m),
        "heights": len(errors.height_m),
        "headings": len(errors.heading_deg),
    }


def errors_summary(errors: FlightErrors) -> Json:
    """All errors of a flight, flown or predicted; the heading's null where none is known."""
    heading = errors.heading_deg.statistics
    return {
        "path_error_m": _both_ways(errors.path_m, "flown"),
        "position_error_m": _statistics(errors.position_m.statistics),
        "height_error_m": _statistics(errors.height_m.statistics),
        "heading_error_deg": None if heading is None else _statistics(heading),
    }


def _both_ways(errors: PathErrors, path: str) -> Json:
    """The path error from the recording to a path, and from that path to the recording."""
    return {
        f"recorded_to_{path}": _statistics(errors.recorded_to_path.statistics),
        f"{path}_to_recorded": _statistics(errors.path_to_recorded.statistics),
    }


def _limits(limits: VehicleLimits) -> Json:
    """The limits that a route is planned with; null as vehicle: the defaults of ArduCopter 4.6."""
    return {
        "vehicle": limits.vehicle,
        **{name: _rounded(value, 4) for name, value in limits.values.items()},
    }


def _heights(heights: RouteHeights) -> Json:
    """The climb to the first waypoint, and which fixes are not flown at their recorded height."""
    return {
        "takeoff_m": heights.takeoff_m,
        "first_waypoint_m": _rounded(heights.first_m),
        "climb_to_first_m": _rounded(heights.first_m - heights.takeoff_m),
        "climb_to_first_s": _rounded(heights.climb_s),
        "floor_m": heights.floor_m,
        "raised_to_floor": _height_change(heights.raised),
        "not_kept": _height_change(heights.limited),
    }


def _height_change(change: HeightChange) -> Json:
    return {"fixes": change.fixes, "max_m": _rounded(change.max_m)}


def _item(seq: int, item: MissionItem) -> Json:
    """An item, as precise as on board: positions to 1e-7 degrees, heights to the centimetre."""
    return {
        "seq": seq,
        "command": int(item.command),
        "frame": int(item.frame),
        "params": [_rounded(param, 4) for param in item.params],
        "lat_deg": _rounded(item.lat_deg, 7),
        "lon_deg": _rounded(item.lon_deg, 7),
        "alt_m": _rounded(item.alt_m, 2),
    }


def _statistics(error: ErrorStatistics | None) -> Json:
    """Mean, 95th percentile and maximum; each null where there is nothing to compare."""
    if error is None:
        return {"mean": None, "p95": None, "max": None}
    return {name: _rounded(value, 4) for name, value in asdict(error).items()}
