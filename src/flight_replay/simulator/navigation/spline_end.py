"""What is left of a spline's motion at its end, where the copter stops.

ArduPilot computes in 32-bit centimetres, whose rounding leaves a velocity at a curve's end that
is not zero: up to some 0.1 mm/s, in an odd direction. By that direction the target's clock
(``track_clock``) judges for as long as the copter waits, and may come almost to a stand, so that
the next leg starts seconds late. The roundings are those of AP_Math/SplineCurve.cpp, in its order
(update_solution, calc_target_pos_vel, calc_dt_speed_max).
"""

from __future__ import annotations

from math import hypot, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.navigation.hermite import Ends
from flight_replay.simulator.navigation.path_limits import PathLimits

_CM = 100.0
_LONGEST_TANGENTS = np.float32(4.0)
_TWO, _THREE, _SIX = np.float32(2.0), np.float32(3.0), np.float32(6.0)
# A length that counts as none (is_zero in AP_Math.h).
_NO_LENGTH = 1.2e-7
_SHARE = 0.5

Floats32 = NDArray[np.float32]


def motion_at_rest(ends: Ends, limits: PathLimits) -> tuple[Vector, float]:
    """Unit vector and speed, m/s, that the target keeps at the end of a curve that ends in a stop.

    Args:
        ends: of the curve, metres; its arriving tangent is zero.
        limits: with which it is flown.
    """
    origin, destination, leaving, arriving = (_centimetres(vector) for vector in ends)
    tangents, chord = _length(leaving) + _length(arriving), _length(destination - origin) * _LONGEST_TANGENTS
    if tangents > chord:
        leaving = leaving * (chord / tangents)
    square = -origin * _THREE - leaving * _TWO + destination * _THREE - arriving
    cube = origin * _TWO + leaving - destination * _TWO + arriving
    velocity = leaving + square * _TWO + cube * _THREE
    accel = square * _TWO + cube * _SIX
    short = destination - (origin + leaving + square + cube)
    return _kept(_exact(velocity), _exact(accel), _exact(short), limits)


def _kept(velocity: Vector, accel: Vector, short: Vector, limits: PathLimits) -> tuple[Vector, float]:
    """Direction, and the speed that curvature and the distance left allow; takes centimetres."""
    rate = hypot(*velocity)
    at_rest = rate < _NO_LENGTH
    along = accel if at_rest else velocity
    length = hypot(*along)
    if length < _NO_LENGTH:
        return (0.0, 0.0, 0.0), 0.0
    unit = (along[0] / length, along[1] / length, along[2] / length)
    speed = limits.speed_along(unit)
    ahead = accel[0] * unit[0] + accel[1] * unit[1] + accel[2] * unit[2]
    across = (accel[0] - ahead * unit[0], accel[1] - ahead * unit[1], accel[2] - ahead * unit[2])
    bend, allowed = hypot(*across), _SHARE * limits.accel_along(across) * _CM
    if not at_rest and bend > _NO_LENGTH and allowed > 0:
        speed = min(speed, rate / sqrt(bend / allowed) / _CM)
    return unit, min(speed, sqrt(2.0 * _SHARE * limits.accel_along(unit) * hypot(*short) / _CM))


def _centimetres(vector: Vector) -> Floats32:
    return np.array([_CM * value for value in vector], np.float32)


def _length(vector: Floats32) -> Any:
    """As a 32-bit number."""
    n, e, u = vector
    return np.sqrt(n * n + e * e + u * u)


def _exact(vector: Floats32) -> Vector:
    n, e, u = vector.tolist()
    return n, e, u
