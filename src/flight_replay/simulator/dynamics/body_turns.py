"""Turns of the body, and what they make of its lean.

A lean is the horizontal part of the thrust over its vertical part, forward and to the right of where the nose
points; turns are about the body's own axes, in rad: its nose down (forward), and its right side down. The
more a vehicle leans, the more a turn changes its lean.
"""

from __future__ import annotations

from math import sqrt

Pair = tuple[float, float]


def turn_between(lean: Pair, wanted: Pair) -> Pair:
    """The shortest turn that brings the thrust from one lean to another (thrust_vector_rotation_angles)."""
    f, r = lean
    wanted_f, wanted_r = wanted
    front_square = 1.0 + f * f
    front, size = sqrt(front_square), sqrt(front_square + r * r)
    wanted_size = sqrt(1.0 + wanted_f * wanted_f + wanted_r * wanted_r)
    forward = (wanted_f - f) / (front * wanted_size)
    right = (front_square * wanted_r - r * (1.0 + f * wanted_f)) / (front * size * wanted_size)
    # So far they are sines. h is the squared sine of half of the angle, whose arc sine the series is:
    # at 60 degrees it is 0.1 % off.
    h = 0.5 - 0.5 * (1.0 + f * wanted_f + r * wanted_r) / (size * wanted_size)
    angle_per_sine = (1.0 + h * (1.0 / 6.0 + h * (3.0 / 40.0 + h * (5.0 / 112.0)))) / sqrt(1.0 - h)
    return forward * angle_per_sine, right * angle_per_sine


def lean_rate(lean: Pair, turn_rate: Pair) -> Pair:
    """How fast a lean changes, 1/s, while the body turns, rad/s."""
    f, r = lean
    forward, right = turn_rate
    front_square = 1.0 + f * f
    front, size = sqrt(front_square), sqrt(front_square + r * r)
    return size * front * forward, size * (r * f * forward + size * right) / front
