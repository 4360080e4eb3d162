"""The readings of the live map: what is planned, what the vehicle reports, its errors, and how it ended."""

from __future__ import annotations

import math
from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING

from flight_replay.output.replay_status import ReplayStatus, battery_text, end_text, following_text
from flight_replay.output.result_text import duration_text
from flight_replay.planning.route import Route

if TYPE_CHECKING:
    from flight_replay.geometry.flight_errors import Errors
    from flight_replay.output.live_map.data import MapPoint

_CELL = "display:inline-block;min-width:6.5em;margin:0 12px 6px 0;vertical-align:top;overflow-wrap:anywhere"


def plan_readings(route: Route) -> Mapping[str, str]:
    """What is known of a route before it is flown, by label."""
    values = {"Length": f"{route.path.length_m:.0f} m"}
    if route.reference is None:
        values["Waypoints"] = f"{len(route.mission.waypoints)}"
    values["Predicted duration"] = duration_text(route.predicted_duration_s)
    if route.predicted is not None:
        values["Predicted path error"] = _mean_and_most(route.predicted.path_m.path_to_recorded)
        values["Predicted position error"] = _mean_and_most(route.predicted.position_m)
        values["Predicted height error"] = _mean_and_most(route.predicted.height_m)
    return values


def _mean_and_most(errors: Errors) -> str:
    known = errors.statistics
    return "" if known is None else f"{known.mean:.1f} m, at most {known.max:.1f} m"


def readings_html(status: ReplayStatus, last: list[MapPoint], plan: Mapping[str, str] | None = None) -> str:
    """The readings as HTML.

    Args:
        status: what is known of the flight.
        last: the latest point, if any.
        plan: what is shown until there is a vehicle.
    """
    values = {"Phase": _phase(status)}
    if status.vehicle is None:
        values |= plan or {}
    values |= _progress(status)
    if status.vehicle is not None:
        values["Altitude"] = f"{status.vehicle.alt_m:.1f} m"
        values["Speed"] = f"{status.speed_m_s:.1f} m/s"
        values["Mode"] = status.mode
        values["Battery"] = battery_text(status.vehicle)
    for point in last:
        values["Path error"] = _metres(point.path_error_m)
        values["Position error"] = _metres(point.position_error_m)
        values["Height error"] = _metres(point.height_error_m)
        values["Heading error"] = (
            f"{point.heading_error_deg:.0f}°" if math.isfinite(point.heading_error_deg) else ""
        )
    values["Problem"] = status.problem or ""
    values["Warning"] = "" if status.warning == status.problem else status.warning
    cells = (
        f'<span style="{_CELL}"><small style="color:#666">{label}</small><br><b>{escape(value)}</b></span>'
        for label, value in values.items()
        if value
    )
    return f'<div style="font:15px/1.3 system-ui,sans-serif">{"".join(cells)}</div>'


def _progress(status: ReplayStatus) -> Mapping[str, str]:
    """Which waypoint the vehicle flies to, or how far it follows the recording."""
    values = {}
    if status.current_waypoint is not None:
        values["Waypoint"] = f"{status.current_waypoint.number} of {status.current_waypoint.waypoints}"
    if status.following is not None:
        name = "Waiting for the vehicle" if status.following.waiting else "Following"
        values[name] = following_text(status.following)
    return values


def _phase(status: ReplayStatus) -> str:
    if status.ended is not None:
        return f"ended: {end_text(status)}"
    name = status.phase.value if status.phase is not None else "planned"
    return f"{name}: {status.waiting}" if status.waiting else name


def _metres(distance_m: float) -> str:
    return f"{distance_m:.1f} m" if math.isfinite(distance_m) else ""
