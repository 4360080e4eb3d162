"""What is left of a spline's motion at its end, where the copter stops.

ArduPilot computes in 32-bit centimetres, whose rounding leaves a velocity at a curve's end that
is not zero: up to some 0.1 mm/s, in an odd direction. AC_WPNav scales the time along the track
(``track_scaler``) by that direction for as long as the copter waits, and may bring it almost to a
standstill, so that the next leg starts seconds late. The roundings are those of
AP_Math/SplineCurve.cpp, in its order (update_solution, calc_target_pos_vel, calc_dt_speed_max).
"""

from __future__ import annotations

from math import hypot, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.navigation.hermite import MAX_TANGENTS_PER_CHORD, Ends
from flight_replay.simulator.navigation.path_limits import PathLimits

_CM = 100.0
_TWO, _THREE, _SIX = np.float32(2.0), np.float32(3.0), np.float32(6.0)
# A length that counts as none (is_zero in AP_Math.h).
_NO_LENGTH = 1.2e-7
# SplineCurve.cpp: LATERAL_ACCEL_SCALER and TANGENTIAL_ACCEL_SCALER.
_ACCEL_SHARE = 0.5

Floats32 = NDArray[np.float32]


def motion_at_rest(ends: Ends, limits: PathLimits) -> tuple[Vector, float]:
    """Unit vector and speed, m/s, that the target keeps at the end of a curve that ends in a stop.

    Args:
        ends: of the curve, metres; its destination tangent is zero.
        limits: with which it is flown.
    """
    origin, destination, origin_tangent, stop = (_centimetres(vector) for vector in ends)
    longest = _length(destination - origin) * np.float32(MAX_TANGENTS_PER_CHORD)
    tangents = _length(origin_tangent) + _length(stop)
    if tangents > longest:
        origin_tangent = origin_tangent * (longest / tangents)
    c2 = -_THREE * origin - _TWO * origin_tangent + _THREE * destination - stop
    c3 = _TWO * origin + origin_tangent - _TWO * destination + stop
    velocity = origin_tangent + c2 * _TWO + c3 * _THREE
    accel = c2 * _TWO + c3 * _SIX
    position_error = destination - (origin + origin_tangent + c2 + c3)
    return _target_motion(_vector(velocity), _vector(accel), _vector(position_error), limits)


def _target_motion(
    velocity: Vector, accel: Vector, position_error: Vector, limits: PathLimits
) -> tuple[Vector, float]:
    """Direction, and the speed that curvature and the remaining distance allow; takes centimetres."""
    derivative = hypot(*velocity)
    at_rest = derivative < _NO_LENGTH
    along = accel if at_rest else velocity
    length = hypot(*along)
    if length < _NO_LENGTH:
        return (0.0, 0.0, 0.0), 0.0
    unit = (along[0] / length, along[1] / length, along[2] / length)
    speed = limits.speed_along(unit)
    tangential = accel[0] * unit[0] + accel[1] * unit[1] + accel[2] * unit[2]
    lateral = (
        accel[0] - tangential * unit[0],
        accel[1] - tangential * unit[1],
        accel[2] - tangential * unit[2],
    )
    curvature, allowed = hypot(*lateral), _ACCEL_SHARE * limits.accel_along(lateral) * _CM
    if not at_rest and curvature > _NO_LENGTH and allowed > 0:
        speed = min(speed, derivative / sqrt(curvature / allowed) / _CM)
    braking = sqrt(2.0 * _ACCEL_SHARE * limits.accel_along(unit) * hypot(*position_error) / _CM)
    return unit, min(speed, braking)


def _centimetres(vector: Vector) -> Floats32:
    return np.array([_CM * value for value in vector], np.float32)


def _length(vector: Floats32) -> Any:
    """As a 32-bit number."""
    n, e, u = vector
    return np.sqrt(n * n + e * e + u * u)


def _vector(vector: Floats32) -> Vector:
    n, e, u = vector.tolist()
    return n, e, u
