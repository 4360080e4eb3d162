"""How near to the recording the model of ArduCopter follows a reference: its predicted errors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.flight_errors import flight_errors
from flight_replay.geometry.movement import Movement
from flight_replay.geometry.reference_motion import ReferenceMotion
from flight_replay.planning.altitude import home_of
from flight_replay.planning.following.braking import braking_within, is_not_pulled
from flight_replay.planning.route import Route
from flight_replay.simulator.flight.guided_trajectory import Targets, simulate_targets
from flight_replay.supervisor.follower import DEFAULT_TUNING, OFF_COURSE, TARGET_S, Follower, Tuning

_ROWS_A_SAMPLE = 5  # Ten samples a second.


def with_prediction(route: Route, max_error_m: float) -> Route:
    """The route with the errors that a vehicle of its limits will have, on a link without delay.

    Args:
        route: a followed one.
        max_error_m: the recording waits for a vehicle that is farther from the reference; a note tells that.
    """
    if route.reference is None:
        return route
    flown = predicted_following(route, route.reference)
    errors = flight_errors(route.wanted, flown, last_s=float(route.wanted.time_s[-1]))
    predicted = replace(route, predicted=errors, predicted_flight=flown)
    return predicted.with_notes(_off_note(route, route.reference, flown, max_error_m))


def _off_note(route: Route, reference: ReferenceMotion, flown: Movement, max_error_m: float) -> str:
    """A sentence on a vehicle that does not follow the reference, though its limits let it; or nothing."""
    wanted_m = reference.positions_m(flown.time_s)
    ground_m = route.frame.to_metres(*reference.frame.to_degrees(wanted_m[:, :2]))
    off_m = np.hypot(np.linalg.norm(flown.north_east_m - ground_m, axis=1), flown.up_m - wanted_m[:, 2])
    worst = int(np.argmax(off_m))
    limits = route.limits.limits
    not_pulled = is_not_pulled(limits)
    if off_m[worst] <= max_error_m and not not_pulled:
        return ""
    options = f" GUID_OPTIONS {limits.guided_options:g} leaves corrections out, those for wind, too;"
    return (
        f"The vehicle's settings do not let it keep to the motion:{options if not_pulled else ''} "
        f"it is predicted {off_m[worst]:.1f} m off, at {flown.time_s[worst]:.0f} s. "
        f"The recording waits for it from {max_error_m:g} m on, and {OFF_COURSE * max_error_m:g} m end the "
        "flight (--max-error)."
    )


def predicted_following(route: Route, reference: ReferenceMotion) -> Movement:
    """The flight of a vehicle that follows a route's reference, its clock the recording's."""
    limits = route.limits.limits
    times_s = np.arange(reference.begin_s, reference.end_s, TARGET_S)
    flight = simulate_targets(
        _targets(reference, times_s, braking_within(DEFAULT_TUNING, limits)),
        limits,
        home_amsl_m=home_of(route.covered).alt_amsl_m or 0.0,
    )
    kept = slice(None, None, _ROWS_A_SAMPLE)
    places_m = np.column_stack([flight.north_m, flight.east_m])[kept]
    ground_m = route.frame.to_metres(*reference.frame.to_degrees(places_m))
    return Movement(flight.time_s[kept], ground_m, flight.up_m[kept], flight.heading_deg[kept])


def _targets(reference: ReferenceMotion, times_s: Floats, tuning: Tuning) -> Targets:
    """The targets that are sent to a vehicle that keeps up."""
    follower = Follower(reference, np.inf, tuning)
    sent = [follower.target(float(time_s)) for time_s in times_s]
    headings_deg = np.array([np.nan if each.heading_deg is None else each.heading_deg for each in sent])
    return Targets(
        times_s,
        np.array([each.position_m for each in sent]),
        np.array([each.velocity_m_s for each in sent]),
        np.array([each.acceleration_m_s2 for each in sent]),
        np.radians(headings_deg),
        np.radians([each.heading_rate_deg_s if each.heading_deg is not None else np.nan for each in sent]),
    )
