"""Jerk- and snap-limited change of speed: the building block of ArduCopter's straight legs.

A ramp raises the speed in three parts: the acceleration grows, holds, and falls again. It grows
along a raised-cosine jerk of ``rise_s`` up and down, with constant jerk for ``hold_jerk_s``
between. Durations follow from snap, jerk, acceleration, the speed change and the length at
hand: SCurve::calculate_path in ArduPilot's AP_Math/SCurve.cpp. The formulas are derived here
from the ramp's symmetry: with ``r`` the time in which the acceleration grows to A and ``c`` the
time it holds, the speed rises by A (r + c), and at the mean speed, so the ramp's length is
(v0 + A (r + c) / 2) (2 r + c).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt
from typing import Final, NamedTuple


class Kinematics(NamedTuple):
    """Snap m/s⁴, jerk m/s³ and acceleration m/s² that a ramp must keep to."""

    snap: float
    jerk: float
    accel: float


@dataclass(frozen=True, slots=True)
class Ramp:
    """Durations, s, and peak jerk, m/s³, of a change of speed; all zero when there is none."""

    jerk: float
    rise_s: float
    hold_jerk_s: float
    hold_accel_s: float


# Below 1.2e-7 cm/s a speed is none (is_zero in AP_Math.h).
_NO_SPEED_M_S: Final = 1.2e-9
NO_RAMP = Ramp(0.0, 0.0, 0.0, 0.0)


def is_error(shape: Ramp) -> bool:
    """Whether ArduPilot reports an internal error: it found no ramp where it looked for one."""
    return shape.jerk <= 0.0 and shape.rise_s > 0.0


def ramp(limits: Kinematics, speed: float, top_speed: float, length: float) -> Ramp:
    """The quickest ramp from ``speed`` towards ``top_speed`` within ``length`` and the limits."""
    snap, jerk, accel = limits
    if speed >= top_speed or min(snap, jerk, accel, top_speed, length) <= 0:
        return NO_RAMP
    rise = jerk * pi / (2.0 * snap)
    accel_fit = min(
        accel,
        (top_speed - speed) / (2.0 * rise),
        (length + 4.0 * speed * rise) / (4.0 * rise * rise),
    )
    if accel_fit < jerk * rise:
        if speed > _NO_SPEED_M_S:
            # ArduPilot keeps the rise and lowers the jerk when it starts from a speed.
            return _small_ramp(accel_fit / rise, rise, speed, top_speed, length)
        rise = min(
            rise,
            (length * pi / (8.0 * snap)) ** 0.25,
            (top_speed * pi / (4.0 * snap)) ** (1.0 / 3.0),
            sqrt(accel * pi / (2.0 * snap)),
        )
        return _small_ramp(2.0 * snap * rise / pi, rise, speed, top_speed, length)
    grow = accel / jerk + rise
    if top_speed - speed < accel * grow or length < (2.0 * speed + accel * grow) * grow:
        peak = min(
            accel,
            _accel_for_speed(jerk, rise, top_speed - speed),
            _accel_for_length(jerk, rise, speed, length),
        )
        if peak < jerk * rise:
            # ArduPilot looks for a full ramp where only a smaller one fits, and then makes none.
            return Ramp(0.0, rise, 0.0, 0.0)
        return Ramp(jerk, rise, peak / jerk - rise, 0.0)
    return Ramp(jerk, rise, accel / jerk - rise, _hold(accel, grow, speed, top_speed, length))


def _small_ramp(jerk: float, rise: float, speed: float, top_speed: float, length: float) -> Ramp:
    """A ramp without constant jerk."""
    accel = jerk * rise
    if top_speed <= speed + 2.0 * accel * rise or length <= 4.0 * rise * (speed + accel * rise):
        return Ramp(jerk, rise, 0.0, 0.0)
    return Ramp(jerk, rise, 0.0, _hold(accel, 2.0 * rise, speed, top_speed, length))


def _hold(accel: float, grow: float, speed: float, top_speed: float, length: float) -> float:
    """Longest time at full acceleration before ``top_speed`` or ``length`` is used up."""
    by_speed = (top_speed - speed) / accel - grow
    mean = speed + 1.5 * accel * grow
    spare = length - 2.0 * grow * (speed + 0.5 * accel * grow)
    by_length = (sqrt(max(0.0, mean * mean + 2.0 * accel * spare)) - mean) / accel
    return max(0.0, min(by_speed, by_length))


def _accel_for_speed(jerk: float, rise: float, change: float) -> float:
    """Peak acceleration of a ramp without hold that changes the speed by ``change``."""
    return 0.5 * (sqrt(jerk * jerk * rise * rise + 4.0 * jerk * change) - jerk * rise)


def _accel_for_length(jerk: float, rise: float, speed: float, length: float) -> float:
    """Peak acceleration of a ramp without hold over ``length``: (2 v0 + A r) r = length, r = A/J + rise.

    In the growing time r this is J r³ - J rise r² + 2 v0 r = length, solved by Newton's method
    from above, where the cubic is convex and rising.
    """
    grow: float = rise + (length / jerk) ** (1.0 / 3.0)
    for _ in range(50):
        value = ((jerk * grow - jerk * rise) * grow + 2.0 * speed) * grow - length
        slope = (3.0 * jerk * grow - 2.0 * jerk * rise) * grow + 2.0 * speed
        change = value / slope
        grow -= change
        if abs(change) < 1e-9 * grow:
            break
    return jerk * (grow - rise)
