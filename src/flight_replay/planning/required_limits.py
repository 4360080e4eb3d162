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

_SPLINE_SHARE = 0.5
_HEADROOM = 1.2
_NEARLY_ALL = 99.0
_WINDOW_S = 1.0
# A copter that flies 10 m/s leans about 20 degrees against the air.
_DRAG_PER_S = 0.35
_STEEPEST_RAD = pi / 4
_MOST_ACCEL_M_S2 = 20.0
# The upper end of PSC_JERK_XY's range.
_MOST_SHAPING_JERK_M_S3 = 20.0


def recorded_limits(track: Track, base: Limits) -> dict[str, float]:
    """Fields of ``Limits`` that have to be raised to fly as recorded, with their values in SI units.

    Args:
        track: fixes of one vehicle; its flown part counts.
        base: what the vehicle is allowed now; nothing is lowered.
    """
    flown, _ = flown_part(track)
    level = _velocity_m_s(flown)
    accel = _nearly_most(np.linalg.norm(_rate(level, flown.time_s), axis=1))
    speed = _nearly_most(np.linalg.norm(level, axis=1))
    climb = _smoothed(np.nan_to_num(flown.up_m_s)[:, None], flown.time_s)[:, 0]
    wanted = min(_HEADROOM * accel / _SPLINE_SHARE, _MOST_ACCEL_M_S2)
    needed = {
        "wp_speed_m_s": _HEADROOM * speed,
        "wp_accel_m_s2": wanted,
        "wp_jerk_m_s3": wanted,
        "shaping_jerk_m_s3": min(2.0 * wanted, _MOST_SHAPING_JERK_M_S3),
        "lean_angle_rad": min(atan((_HEADROOM * accel + _DRAG_PER_S * speed) / GRAVITY_M_S2), _STEEPEST_RAD),
        "wp_speed_up_m_s": _HEADROOM * _nearly_most(climb),
        "wp_speed_down_m_s": _HEADROOM * _nearly_most(-climb),
        "wp_accel_z_m_s2": _HEADROOM * _nearly_most(np.abs(_rate(climb[:, None], flown.time_s))[:, 0]),
    }
    now = {field.name: getattr(base, field.name) for field in fields(base)}
    return {name: value for name, value in needed.items() if value > now[name]}


def _velocity_m_s(track: Track) -> Floats:
    """Velocity north and east (n, 2), as recorded, or from the places where the log does not tell."""
    told = np.column_stack([track.north_m_s, track.east_m_s])
    if not np.isfinite(told).all():
        told = _rate(track.north_east_m(), track.time_s)
    return _smoothed(told, track.time_s)


def _rate(values: Floats, time_s: Floats) -> Floats:
    """Change per second (n, d), across two neighbours."""
    if len(values) < 3:
        return np.zeros_like(values)
    span_s = np.maximum(time_s[2:] - time_s[:-2], 1e-3)[:, None]
    inner = (values[2:] - values[:-2]) / span_s
    return np.concatenate([inner[:1], inner, inner[-1:]])


def _smoothed(values: Floats, time_s: Floats) -> Floats:
    """Means (n, d) over about ``_WINDOW_S``, so that noise does not pass for manoeuvres."""
    usual_s = float(np.median(np.diff(time_s))) if len(time_s) > 1 else _WINDOW_S
    half = int(_WINDOW_S / (2 * max(usual_s, 1e-3)))
    if half == 0 or len(values) <= 2 * half:
        return values
    total = np.cumsum(np.pad(values, ((half + 1, half), (0, 0)), mode="edge"), axis=0)
    return np.asarray((total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1))


def _nearly_most(values: Floats) -> float:
    return float(np.percentile(values, _NEARLY_ALL)) if len(values) else 0.0
