"""How hard targets brake until the next one comes, and how far ahead they have to be for that not to matter.

ArduCopter goes on with a target's velocity and acceleration while no other comes. One that brakes makes a
vehicle that gets no more targets slow down in the turn that it flies, instead of fly on at speed and brake
straight on after ``GUID_TIMEOUT``. Until then what pulls it to a target that is ahead makes up for it.
"""

from __future__ import annotations

from dataclasses import replace

from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.supervisor.follower import Tuning

_SHARE = 0.8
"""Of the acceleration that ArduCopter corrects with at most; the rest is left to corrections."""
_SLOWER_SHARE = 0.5
"""Of the braking, what slower targets take away as well: the sooner a vehicle without targets slows down."""
_FARTHEST_AHEAD_M = 1.5
_NOT_PULLED = 16 | 32
"""Bits of GUID_OPTIONS: targets pull neither by their position nor, with the second, by their velocity."""


def braking_within(tuning: Tuning, limits: Limits) -> Tuning:
    """The tuning of a firmware whose targets brake, with the braking that a vehicle's limits allow.

    A target pulls in proportion to its velocity, by ``gain_per_s``, and to its distance, by half of the
    square of that, up to the largest correction (shape_pos_vel_accel_xy and shape_vel_accel_xy of
    control.cpp). What it pulls with at its distance makes up for its braking and for its lower velocity.
    """
    gain_per_s = limits.correction_jerk_m_s3 / limits.wp_accel_m_s2 if limits.wp_accel_m_s2 > 0 else 0.0
    if tuning.braking_m_s2 == 0.0 or gain_per_s <= 0.0 or is_not_pulled(limits):
        return replace(tuning, braking_m_s2=0.0, braking_ahead_m=0.0, braking_slower_m_s=0.0)
    ahead_m_per_m_s2 = (1 + _SLOWER_SHARE) * 2 / gain_per_s**2
    braking_m_s2 = min(_SHARE * limits.wp_accel_m_s2, _FARTHEST_AHEAD_M / ahead_m_per_m_s2)
    return replace(
        tuning,
        braking_m_s2=braking_m_s2,
        braking_ahead_m=braking_m_s2 * ahead_m_per_m_s2,
        braking_slower_m_s=_SLOWER_SHARE * braking_m_s2 / gain_per_s,
    )


def is_not_pulled(limits: Limits) -> bool:
    """Whether the vehicle's options leave out the corrections that pull it to targets."""
    return bool(int(limits.guided_options) & _NOT_PULLED)
