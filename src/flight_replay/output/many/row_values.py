"""What is known of a log, its flight, the plan and the replay, as values of the table's columns."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from flight_replay.output.many.flight_columns import BOTH_WAYS, COLUMN_OF, ERRORS, Status, error_column

if TYPE_CHECKING:
    from flight_replay.geometry.error_statistics import ErrorStatistics
    from flight_replay.geometry.flight_errors import FlightErrors, PathErrors
    from flight_replay.logs.flights import Flight
    from flight_replay.logs.recording import Recording
    from flight_replay.output.outcome import Outcome
    from flight_replay.planning.route import Route

Values = dict[str, Any]

_SIGNIFICANT_DECIMALS = 4


def recording_values(recording: Recording) -> Values:
    """What is the same for all flights of a vehicle in a log."""
    vehicle = recording.vehicle
    return {
        "log_format": recording.format,
        "vehicle_system": None if vehicle is None else vehicle.system,
        "vehicle_component": None if vehicle is None else vehicle.component,
        "vehicle_type": recording.vehicle_type,
        "is_multicopter": recording.is_multicopter,
        "recorded_firmware": recording.firmware,
        "log_fixes": len(recording.track),
        "without_position": recording.without_position,
        "rejected": recording.rejected_total,
        "rejected_by_reason": json.dumps(dict(recording.rejected)),
    }


def flight_values(recording: Recording, flight: Flight, of: int) -> Values:
    """When, where, how long and how high a flight was, of so many in the log."""
    track, start_utc_s = recording.track, recording.start_utc_s
    return {
        "flight": flight.number,
        "flights": of,
        "start_utc_s": None if start_utc_s is None else start_utc_s + flight.start_s,
        "start_s": flight.start_s,
        "duration_s": flight.end_s - flight.start_s,
        "start_lat_deg": float(track.lat_deg[flight.first]),
        "start_lon_deg": float(track.lon_deg[flight.first]),
        "end_lat_deg": float(track.lat_deg[flight.last]),
        "end_lon_deg": float(track.lon_deg[flight.last]),
        "length_m": flight.length_m,
        "highest_m": flight.highest_m,
        "top_speed_m_s": flight.top_speed_m_s,
        "fixes": flight.fixes,
    }


def doubt_values(said: Sequence[str], *, is_planned: bool) -> Values:
    """Whether a flight is fit for replay, and what speaks against it."""
    return {"fit_for_replay": is_planned and not said, "doubts": "; ".join(said) or None}


def route_values(route: Route) -> Values:
    """The plan, how far it is from the recording, and how far the model flies it from that."""
    return {
        "method": route.method,
        "waypoints": 0 if route.reference is not None else len(route.mission.waypoints),
        "fixes_covered": len(route.recorded),
        "planned_length_m": route.path.length_m,
        **_path_values("planned", route.planned_error),
        "predicted_duration_s": route.predicted_duration_s,
        **({} if route.predicted is None else _error_values("predicted", route.predicted)),
    }


def replay_values(flown_by: str, vehicle: str, outcome: Outcome) -> Values:
    """How a flight was flown again, by what, and how far from the recording."""
    record = outcome.record
    return {
        "flown_by": flown_by,
        "flown_vehicle": vehicle,
        "waypoints_reached": record.waypoints_reached,
        "ended": record.ended,
        "rtl_confirmed": None if flown_by == "model" else record.rtl_confirmed,
        "auto_s": record.auto_s,
        "fixes_flown": outcome.coverage.fixes,
        **_error_values("flown", outcome.errors),
        "status": Status.FLOWN if record.problem is None else Status.FAILED,
        "problem": record.problem,
    }


def clean(values: Values) -> Values:
    """The values that a row keeps: known columns in order, numbers that are numbers, text that is Unicode.

    Raises:
        KeyError: A value has no column.
    """
    unknown = values.keys() - COLUMN_OF.keys()
    if unknown:
        raise KeyError(f"no column {', '.join(sorted(unknown))}")
    kept = {name: _cleaned(name, values[name]) for name in COLUMN_OF if values.get(name) is not None}
    return {name: value for name, value in kept.items() if value is not None}


def _cleaned(name: str, value: Any) -> Any:
    kind = COLUMN_OF[name].kind
    if kind == "number":
        digits = (
            8 if name.endswith("_deg") and ("_lat_" in name or "_lon_" in name) else _SIGNIFICANT_DECIMALS
        )
        return round(float(value), digits) + 0.0 if math.isfinite(value) else None
    if kind == "text":  # names of files may hold any bytes
        return str(value).encode(errors="backslashreplace").decode()
    return int(value) if kind == "whole" else bool(value)


def _error_values(prefix: str, errors: FlightErrors) -> Values:
    return {
        **_path_values(prefix, errors.path_m),
        **_statistics(prefix, "position", errors.position_m.statistics),
        **_statistics(prefix, "height", errors.height_m.statistics),
        **_statistics(prefix, "heading", errors.heading_deg.statistics),
    }


def _path_values(prefix: str, errors: PathErrors) -> Values:
    there, back = BOTH_WAYS
    return {
        **_statistics(prefix, there, errors.recorded_to_path.statistics),
        **_statistics(prefix, back, errors.path_to_recorded.statistics),
    }


def _statistics(prefix: str, error: str, statistics: ErrorStatistics | None) -> Values:
    assert error in ERRORS
    if statistics is None:
        return {}
    return {error_column(prefix, error, name): value for name, value in asdict(statistics).items()}
