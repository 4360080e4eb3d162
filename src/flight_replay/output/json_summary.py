"""The ``--json`` object, which other programs read: its keys and units do not change.

Lengths in metres, times in seconds, angles in degrees, unless the key says otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from flight_replay.mission.items import FIRST_SEQ, MissionItem

if TYPE_CHECKING:
    from flight_replay.geometry.distances import ErrorStatistics
    from flight_replay.logs.flights import Flight
    from flight_replay.logs.tlog import Log
    from flight_replay.output.outcome import Outcome
    from flight_replay.planning.route import Route
    from flight_replay.supervisor.flight_plan import FlightRecord

Json = Mapping[str, Any]


def log_summary(log: Log, flights: Sequence[Flight]) -> Json:
    """The "log" object; ``fixes`` counts the usable fixes of the chosen vehicle."""
    return {
        "path": log.path,
        "bytes": log.bytes,
        "fixes": len(log.track),
        "without_position": log.without_position,
        "rejected": sum(log.rejected.values()),
        "vehicles": [
            {"system": each.system, "component": each.component, "fixes": each.fixes} for each in log.vehicles
        ],
        "flights": [
            {
                "number": flight.number,
                "start_s": round(flight.start_s, 3),
                "end_s": round(flight.end_s, 3),
                "fixes": flight.fixes,
                "length_m": round(flight.length_m, 3),
            }
            for flight in flights
        ],
    }


def route_summary(route: Route) -> Json:
    """The "route" object; its items do not include home."""
    return {
        "method": route.method,
        "points": len(route.mission.waypoints),
        "items": [_item(seq, item) for seq, item in enumerate(route.mission.items, FIRST_SEQ)],
        "fixes_covered": len(route.covered),
        "length_m": round(route.path.length_m, 3),
        "planned_error_m": _statistics(route.planned_error),
        "predicted_duration_s": round(route.predicted_duration_s, 3),
    }


def flight_summary(vehicle: str, simulated: bool, record: FlightRecord, outcome: Outcome) -> Json:
    """The "flight" object."""
    return {
        "vehicle": vehicle,
        "simulated": simulated,
        "waypoints_reached": record.waypoints_reached,
        "ended": record.ended,
        "auto_s": round(record.auto_s, 3),
        "rtl_confirmed": record.rtl_confirmed,
        "distance_in_space_m": _statistics(outcome.path_error),
        "distance_in_time_m": _statistics(outcome.position_error),
    }


def _item(seq: int, item: MissionItem) -> Json:
    return {
        "seq": seq,
        "command": int(item.command),
        "frame": int(item.frame),
        "params": list(item.params),
        "lat_deg": item.lat_deg,
        "lon_deg": item.lon_deg,
        "alt_m": item.alt_m,
    }


def _statistics(error: ErrorStatistics | None) -> Json:
    """Mean, 95th percentile and maximum; each null where there is nothing to compare."""
    if error is None:
        return {"mean": None, "p95": None, "max": None}
    return {name: round(value, 4) for name, value in asdict(error).items()}
