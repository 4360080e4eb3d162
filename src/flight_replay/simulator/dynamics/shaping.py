"""Kinematic shaping on one axis and in the plane, as ArduPilot's AP_Math/control.cpp does it.

Plain floats in any consistent units: these run at every step of the simulation.
"""

from __future__ import annotations

from math import hypot, pi, sqrt


def clamp(value: float, low: float, high: float) -> float:
    """``value``, not below ``low`` and not above ``high``."""
    return low if value < low else high if value > high else value


def wrap_pi(angle_rad: float) -> float:
    """The same angle from -pi to pi (wrap_PI in AP_Math.cpp)."""
    return (angle_rad + pi) % (2.0 * pi) - pi


def sqrt_controller(error: float, p: float, second_limit: float, dt: float) -> float:
    """Correction rate towards zero error: proportional near it, decelerating at ``second_limit`` far off.

    Source: sqrt_controller in control.cpp. With ``dt`` above 0 one step never overshoots.
    """
    size = abs(error)
    if second_limit <= 0:
        rate = size * p
    elif p == 0:
        rate = sqrt(2.0 * second_limit * size)
    else:
        linear = second_limit / (p * p)
        rate = size * p if size <= linear else sqrt(2.0 * second_limit * (size - 0.5 * linear))
    if dt > 0 and rate * dt > size:
        rate = size / dt
    return rate if error > 0 else -rate


def stopping_distance(speed: float, p: float, decel: float) -> float:
    """Distance in which a square-root controller stops (inv_sqrt_controller in control.cpp)."""
    if abs(speed) < decel / p:
        return speed / p
    distance = 0.5 * decel / (p * p) + speed * speed / (2.0 * decel)
    return distance if speed > 0 else -distance


def kinematic_limit(direction: tuple[float, float, float], level: float, up: float, down: float) -> float:
    """Largest length along a direction, north, east, up, within horizontal and vertical limits.

    Source: kinematic_limit in control.cpp; 0 without a direction.
    """
    n, e, u = direction
    flat = hypot(n, e)
    length = hypot(flat, u)
    if length == 0 or level == 0 or up == 0 or down == 0:
        return 0.0
    rise = abs(up if u > 0 else down)
    if abs(u) * level < rise * flat:
        return level * length / flat
    return rise * length / abs(u)


def step_towards(target: float, value: float, step: float) -> float:
    """``value`` moved towards ``target`` by at most ``step`` (shape_accel in control.cpp)."""
    change = target - value
    return value + (step if change > step else -step if change < -step else change)


def shape_velocity(error: float, accel: float, accel_max: float, jerk: float, dt: float) -> float:
    """Next acceleration that removes a velocity ``error`` within ``accel_max`` and ``jerk``.

    Source: shape_vel_accel in control.cpp, with equal limits both ways and nothing fed forward.
    """
    target = clamp(sqrt_controller(error, jerk / accel_max, jerk, dt), -accel_max, accel_max)
    return step_towards(target, accel, jerk * dt)


def shape_position(
    error: float, speed: float, accel: float, limits: tuple[float, float, float, float], dt: float
) -> float:
    """Next acceleration that removes a position ``error`` and then rests.

    Source: shape_pos_vel_accel in control.cpp for a resting goal. ``limits`` are lowest and
    highest velocity, acceleration and jerk.
    """
    speed_min, speed_max, accel_max, jerk = limits
    wanted = sqrt_controller(error, 0.5 * jerk / accel_max, 0.5 * accel_max, dt)
    return shape_velocity(clamp(wanted, speed_min, speed_max) - speed, accel, accel_max, jerk, dt)


def shape_velocity_xy(
    speed: tuple[float, float], accel: tuple[float, float], accel_max: float, jerk: float, dt: float
) -> tuple[float, float]:
    """Next horizontal acceleration that removes a velocity error (shape_vel_accel_xy)."""
    vn, ve = speed
    size = hypot(vn, ve)
    rate = min(sqrt_controller(size, jerk / accel_max, jerk, dt), accel_max) if size > 0 else 0.0
    scale = -rate / size if size > 0 else 0.0
    dn, de = vn * scale - accel[0], ve * scale - accel[1]
    change = hypot(dn, de)
    keep = min(1.0, jerk * dt / change) if change > 0 else 0.0
    return accel[0] + dn * keep, accel[1] + de * keep


def limit_accel_xy(
    accel: tuple[float, float], speed: tuple[float, float], accel_max: float
) -> tuple[float, float]:
    """Limit an acceleration to ``accel_max``, first of all its part along the velocity.

    Source: limit_accel_xy in control.cpp.
    """
    an, ae = accel
    if an * an + ae * ae <= accel_max * accel_max:
        return accel
    size = hypot(*speed)
    if size == 0:
        scale = accel_max / hypot(an, ae)
        return an * scale, ae * scale
    n, e = speed[0] / size, speed[1] / size
    along, across = an * n + ae * e, ae * n - an * e
    across = clamp(across, -accel_max, accel_max)
    room = sqrt(accel_max * accel_max - across * across)
    along = clamp(along, -room, room)
    return along * n - across * e, along * e + across * n
