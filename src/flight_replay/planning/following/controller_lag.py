"""How far a vehicle is beside its targets because its controllers are not told all that it takes.

ArduCopter feeds the acceleration of a target forward, 3.3 only a part of it, but not the drag at its
velocity. What is left only the velocity controller's errors make up for, first in proportion, then by
its integral. Where the speed has just changed, the vehicle is off. Targets displaced by that lag put it
right.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.reference_motion import ReferenceMotion, SmoothMotion, motion_through
from flight_replay.planning.drag import Drag
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.supervisor.follower import DEFAULT_TUNING, Tuning

_STEP_S = 0.05
_KNOT_STEPS = 5  # 0.25 s, as the reference's.
_MOST_M = 5.0  # With the gains of 4.6 it is up to 1.5 m, with those of 3.3 up to 4.5 m: no more is trusted.


def drag_lag(
    reference: ReferenceMotion, drag: Drag, limits: Limits, tuning: Tuning = DEFAULT_TUNING
) -> SmoothMotion | None:
    """The displacement of targets that makes up for all of a drag, level and bounded; None with absurd gains.

    Args:
        reference: what is followed.
        drag: of the vehicle.
        limits: with the gains of its position and velocity controllers.
        tuning: that of its firmware.
    """
    times_s = _times_s(reference)
    velocity_m_s = _level(reference.velocities_m_s, reference, times_s + tuning.delay_s)
    return _lag(times_s, drag.acceleration_m_s2(velocity_m_s), limits, tuning)


def acceleration_lag(reference: ReferenceMotion, limits: Limits, tuning: Tuning) -> SmoothMotion | None:
    """The same for the acceleration that is not fed forward, or late; None where it is."""
    if tuning.feed_forward == 1.0 and tuning.delay_s == 0.0:
        return None
    times_s = _times_s(reference)
    now_m_s2 = _level(reference.accelerations_m_s2, reference, times_s)
    due_m_s2 = _level(reference.accelerations_m_s2, reference, times_s + tuning.delay_s)
    return _lag(times_s, due_m_s2 - tuning.feed_forward * now_m_s2, limits, tuning)


def _times_s(reference: ReferenceMotion) -> Floats:
    spans = max(int(np.ceil((reference.end_s - reference.begin_s) / (_STEP_S * _KNOT_STEPS))), 4)
    return np.linspace(reference.begin_s, reference.end_s, spans * _KNOT_STEPS + 1)


def _level(values: Callable[[Floats], Floats], reference: ReferenceMotion, times_s: Floats) -> Floats:
    """Values (n, 2) north and east of the reference at times (n,), at both ends those of the ends."""
    return values(np.clip(times_s, reference.begin_s, reference.end_s))[:, :2]


def _lag(times_s: Floats, missing_m_s2: Floats, limits: Limits, tuning: Tuning) -> SmoothMotion | None:
    """The lag for a missing acceleration (n, 2)."""
    with np.errstate(all="ignore"):
        step_s = float(times_s[1] - times_s[0])
        lag_m = _lag_m(missing_m_s2, step_s, limits, tuning)[::_KNOT_STEPS]
    if not np.isfinite(lag_m).all():
        return None
    lag_m *= np.minimum(1.0, _MOST_M / np.maximum(np.linalg.norm(lag_m, axis=1, keepdims=True), 1e-9))
    return motion_through(times_s[::_KNOT_STEPS], np.pad(lag_m, ((0, 0), (0, 1))))


def _lag_m(missing_m_s2: Floats, step_s: float, limits: Limits, tuning: Tuning) -> Floats:
    """The lag (n, 2) of a copter for a missing acceleration (n, 2), which is constant in each step.

    With x the lag, the position controller adds u = x' + p x to the velocity error, and the velocity
    controller and the feed-forward have to make what is missing: x'' + d u' + k u + i integral(u). Where
    the feed-forward f is of the velocity's change, it is f u' instead of x''. The state is the integral
    of x, x and x'.
    """
    from scipy.linalg import expm

    fed, derivative = 1.0, limits.velocity_d
    if tuning.feed_forward < 1.0:
        fed, derivative = 0.0, limits.velocity_d + tuning.feed_forward
    gain = fed + derivative
    loop = np.convolve([derivative, limits.velocity_p, limits.velocity_i], [1.0, limits.position_p])
    system = np.zeros((4, 4))
    system[0, 1] = system[1, 2] = 1.0
    system[2] = [*(-loop[:0:-1] / gain), 1.0 / gain]
    exact = expm(system * step_s)
    states = np.zeros((len(missing_m_s2), 3, 2))
    for step in range(1, len(states)):
        states[step] = exact[:3, :3] @ states[step - 1] + exact[:3, 3:] * missing_m_s2[step - 1]
    return states[:, 1]
