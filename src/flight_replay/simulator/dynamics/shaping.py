"""Kinematic shaping on one axis and in the plane, as ArduPilot's AP_Math/control.cpp does it.

Plain floats in any consistent units: these run at every step of the simulation.
"""

from __future__ import annotations

from math import pi, sqrt

from flight_replay.simulator.dynamics.vector import norm


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
    size = error if error > 0 else -error
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
    if level == 0 or up == 0 or down == 0:
        return 0.0
    if u == 0:
        return level if n or e else 0.0
    flat = norm(n, e)
    length = norm(n, e, u)
    rise = abs(up if u > 0 else down)
    if abs(u) * level < rise * flat:
        return level * length / flat
    return rise * length / abs(u)


def step_towards(target: float, value: float, step: float) -> float:
    """``value`` moved towards ``target`` by at most ``step`` (shape_accel in control.cpp)."""
    change = target - value
    return value + (step if change > step else -step if change < -step else change)


def shape_velocity(  # noqa: PLR0913
    error: float, accel: float, accel_max: float, jerk: float, dt: float, *, feed: float = 0.0
) -> float:
    """Next acceleration that removes a velocity ``error`` within ``accel_max`` and ``jerk``.

    Source: shape_vel_accel in control.cpp, with equal limits both ways. ``feed`` is the
    acceleration fed forward, which only ``jerk`` limits.
    """
    target = clamp(sqrt_controller(error, jerk / accel_max, jerk, dt), -accel_max, accel_max)
    return step_towards(target + feed, accel, jerk * dt)


def shape_position(  # noqa: PLR0913
    error: float,
    speed: float,
    accel: float,
    limits: tuple[float, float, float, float],
    dt: float,
    *,
    feed: tuple[float, float] = (0.0, 0.0),
) -> float:
    """Next acceleration that removes a position ``error``.

    Source: shape_pos_vel_accel in control.cpp. ``limits`` are lowest and highest velocity of the
    correction, its acceleration, and jerk; ``feed`` velocity and acceleration of the goal.
    """
    speed_min, speed_max, accel_max, jerk = limits
    wanted = clamp(sqrt_controller(error, 0.5 * jerk / accel_max, 0.5 * accel_max, dt), speed_min, speed_max)
    return shape_velocity(wanted + feed[0] - speed, accel, accel_max, jerk, dt, feed=feed[1])


def shape_velocity_xy(  # noqa: PLR0913
    wanted: tuple[float, float],
    speed: tuple[float, float],
    accel: tuple[float, float],
    limits: tuple[float, float],
    dt: float,
    *,
    feed: tuple[float, float] = (0.0, 0.0),
) -> tuple[float, float]:
    """Next horizontal acceleration towards a wanted velocity (shape_vel_accel_xy).

    ``limits`` are acceleration of the correction, and jerk; ``feed`` is the acceleration fed
    forward, which only the jerk limits.
    """
    accel_max, jerk = limits
    n, e = wanted[0] - speed[0], wanted[1] - speed[1]
    size = norm(n, e)
    if size > 0:
        rate = sqrt_controller(size, jerk / accel_max, jerk, dt) / size
        n, e = _limit_correction_xy((n * rate, e * rate), wanted, accel_max)
    return step_towards_xy((n + feed[0], e + feed[1]), accel, jerk * dt)


def step_towards_xy(
    target: tuple[float, float], value: tuple[float, float], step: float
) -> tuple[float, float]:
    """``value`` moved towards ``target`` by at most ``step`` (shape_accel_xy in control.cpp)."""
    n, e = target[0] - value[0], target[1] - value[1]
    size = norm(n, e)
    keep = step / size if size > step else 1.0
    return value[0] + n * keep, value[1] + e * keep


def _limit_correction_xy(
    accel: tuple[float, float], wanted: tuple[float, float], accel_max: float
) -> tuple[float, float]:
    """Limit a correction; across the wanted velocity at least half of its square stays possible."""
    an, ae = accel
    size_squared = an * an + ae * ae
    if size_squared <= accel_max * accel_max:
        return accel
    n, e = wanted
    speed = norm(n, e)
    if speed > 0:
        n, e = n / speed, e / speed
    along, across = an * n + ae * e, ae * n - an * e
    if along * along <= across * across or speed == 0:
        scale = accel_max / sqrt(size_squared)
        return an * scale, ae * scale
    most = accel_max * sqrt(0.5)
    across = clamp(across, -most, most)
    room = sqrt(accel_max * accel_max - across * across)
    along = clamp(along, -room, room)
    return along * n - across * e, along * e + across * n


def limit_accel_xy(
    accel: tuple[float, float], speed: tuple[float, float], accel_max: float
) -> tuple[float, float]:
    """Limit an acceleration to ``accel_max``, first of all its part along the velocity.

    Source: limit_accel_xy in control.cpp.
    """
    an, ae = accel
    if an * an + ae * ae <= accel_max * accel_max:
        return accel
    n, e = speed
    size = norm(n, e)
    if size == 0:
        scale = accel_max / norm(an, ae)
        return an * scale, ae * scale
    n, e = n / size, e / size
    along, across = an * n + ae * e, ae * n - an * e
    across = clamp(across, -accel_max, accel_max)
    room = sqrt(accel_max * accel_max - across * across)
    along = clamp(along, -room, room)
    return along * n - across * e, along * e + across * n
