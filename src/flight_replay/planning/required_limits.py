"""The limits that a vehicle needs to keep up with a recording: ``--limits recorded``, for simulators.

ArduCopter flies spline legs with half of its acceleration, along the track and across; its lean
angle has to give the acceleration and to push against the air besides.
"""

from __future__ import annotations

from dataclasses import fields
from math import atan, pi

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.logs.track import Track
from flight_replay.planning.flown_part import flown_part
from flight_replay.simulator.dynamics.limits import GRAVITY_M_S2, Limits

_SPLINE_ACCEL_SHARE = 0.5
_HEADROOM = 1.2
"""Room for the vehicle to catch up, over what was recorded."""
_PERCENTILE = 99.0
"""A maximum that single outliers do not set."""
_WINDOW_S = 1.0
"""Velocities are averaged over this long, so that their noise is not taken for manoeuvres."""
_DRAG_PER_S = 0.35
"""Deceleration by the air per speed: a copter that flies 10 m/s leans about 20 degrees against it."""
_MAX_LEAN_RAD = pi / 4
_MAX_ACCEL_M_S2 = 20.0
_MAX_SHAPING_JERK_M_S3 = 20.0
"""The upper end of PSC_JERK_XY's range."""
_MIN_STEP_S = 1e-3


def required_limits(track: Track, base: Limits) -> dict[str, float]:
    """Fields of ``Limits`` that have to be raised to fly as recorded, with their values in SI units.

    Args:
        track: fixes of one vehicle; its flown part counts.
        base: what the vehicle is allowed now; nothing is lowered.
    """
    flown, _ = flown_part(track)
    velocity = _velocity_m_s(flown)
    climb = _averaged(np.nan_to_num(flown.up_m_s)[:, None], flown.time_s)
    speed = _maximum(np.linalg.norm(velocity, axis=1))
    accel = _maximum(np.linalg.norm(_rate(velocity, flown.time_s), axis=1))
    spline_accel = min(_HEADROOM * accel / _SPLINE_ACCEL_SHARE, _MAX_ACCEL_M_S2)
    required = {
        "wp_speed_m_s": _HEADROOM * speed,
        "wp_accel_m_s2": spline_accel,
        "wp_jerk_m_s3": spline_accel,
        "shaping_jerk_m_s3": min(2.0 * spline_accel, _MAX_SHAPING_JERK_M_S3),
        "lean_angle_rad": min(atan((_HEADROOM * accel + _DRAG_PER_S * speed) / GRAVITY_M_S2), _MAX_LEAN_RAD),
        "wp_speed_up_m_s": _HEADROOM * _maximum(climb),
        "wp_speed_down_m_s": _HEADROOM * _maximum(-climb),
        "wp_accel_z_m_s2": _HEADROOM * _maximum(np.abs(_rate(climb, flown.time_s))),
    }
    now = {field.name: getattr(base, field.name) for field in fields(base)}
    return {name: value for name, value in required.items() if value > now[name]}


def _velocity_m_s(track: Track) -> Floats:
    """Velocity north and east (n, 2), as recorded, or from the positions where the log has none."""
    recorded = np.column_stack([track.north_m_s, track.east_m_s])
    if not np.isfinite(recorded).all():
        recorded = _rate(track.north_east_m(), track.time_s)
    return _averaged(recorded, track.time_s)


def _rate(values: Floats, time_s: Floats) -> Floats:
    """Change per second (n, d) of values (n, d), from the fix before to the fix behind."""
    if len(values) < 3:
        return np.zeros_like(values)
    span_s = np.maximum(time_s[2:] - time_s[:-2], _MIN_STEP_S)[:, None]
    inner = (values[2:] - values[:-2]) / span_s
    return np.concatenate([inner[:1], inner, inner[-1:]])


def _averaged(values: Floats, time_s: Floats) -> Floats:
    """Moving averages (n, d) of values (n, d) over about ``_WINDOW_S``."""
    step_s = float(np.median(np.diff(time_s))) if len(time_s) > 1 else _WINDOW_S
    half = int(_WINDOW_S / (2 * max(step_s, _MIN_STEP_S)))
    if half == 0 or len(values) <= 2 * half:
        return values
    total = np.cumsum(np.pad(values, ((half + 1, half), (0, 0)), mode="edge"), axis=0)
    return np.asarray((total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1))


def _maximum(values: Floats) -> float:
    """The largest of some values but for outliers; 0 where there are none."""
    return float(np.percentile(values, _PERCENTILE)) if values.size else 0.0
