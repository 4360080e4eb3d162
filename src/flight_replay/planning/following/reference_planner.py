"""Plans the reference: the motion nearest to the recording, in step with it, that the vehicle can fly.

Bounds stay below the vehicle's limits: at its limit of lean the controllers wind up, and fly off
course by metres; a share of it is left to corrections and wind, a larger one where the vehicle turns.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, tan

import numpy as np

from flight_replay.exceptions import MissionError
from flight_replay.geometry.arrays import Flags, Floats
from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.geometry.reference_motion import ReferenceMotion
from flight_replay.planning.drag import Drag
from flight_replay.planning.following.lean import MostThrust, lean_bound
from flight_replay.planning.following.samples import filled
from flight_replay.planning.smoothing import Bound, Knots, Samples, length_bound, nearest_motion
from flight_replay.simulator.dynamics.limits import GRAVITY_M_S2, Limits

LEAD_S = 5.0
"""Time to get up to the first fix's speed, and to come to rest behind the last."""
_ALONG_SHARE, _ACROSS_SHARE = 0.94, 0.88
"""Of what the lean gives: with more along the way, wind makes vehicles late by more than that brings them
nearer without; with more across, it throws them farther off the path, and so does a stream that stops."""
_KNOT_STEP_S = 0.25
_SMOOTHNESS_S6 = 1e-3  # Motions of less than about 0.3 s are noise.
_HEADING_SMOOTHNESS_S6 = 1e-3
_FASTEST_TURN_RAD_S, _FASTEST_TURN_RAD_S2 = 2.0 * pi, 4.0 * pi
"""Where the vehicle's parameters set no limit, by 0: a turn a second."""
_ROUNDS = 5
_SETTLED_M_S = 0.05


@dataclass(frozen=True, slots=True)
class ReferenceBounds:
    """What a reference keeps to: horizontal thrust per mass, jerk, climb and descent, turning."""

    thrust: MostThrust
    jerk_m_s3: float
    up_m_s: float
    down_m_s: float
    vertical_m_s2: float
    vertical_jerk_m_s3: float
    turn_deg_s: float
    turn_deg_s2: float

    @classmethod
    def of(cls, limits: Limits) -> ReferenceBounds:
        """The bounds within a vehicle's limits."""
        most_m_s2 = GRAVITY_M_S2 * tan(limits.lean_angle_rad)
        return cls(
            thrust=MostThrust(_ALONG_SHARE * most_m_s2, _ACROSS_SHARE * most_m_s2),
            jerk_m_s3=0.6 * limits.shaping_jerk_m_s3,
            up_m_s=limits.wp_speed_up_m_s,
            down_m_s=limits.wp_speed_down_m_s,
            vertical_m_s2=2.0 * limits.wp_accel_z_m_s2,
            vertical_jerk_m_s3=limits.shaping_jerk_z_m_s3,
            turn_deg_s=0.98 * float(np.degrees(limits.yaw_slew_rad_s or _FASTEST_TURN_RAD_S)),
            turn_deg_s2=0.5 * float(np.degrees(limits.yaw_accel_rad_s2 or _FASTEST_TURN_RAD_S2)),
        )


@dataclass(frozen=True, slots=True, eq=False)
class RecordedMotion:
    """What is to be followed: times (n,) from 0 on, metres (n, 3) in ``frame`` and above home, headings.

    ``heading_deg`` (n,) is not a number where it is unknown.
    """

    frame: FlatFrame
    time_s: Floats
    position_m: Floats
    heading_deg: Floats


def plan_reference(
    recorded: RecordedMotion, bounds: ReferenceBounds, drag: Drag, *, headings: bool, floor_m: float
) -> ReferenceMotion:
    """The reference of a recording.

    Args:
        recorded: at least two fixes.
        bounds: what the reference keeps to.
        drag: what lean the vehicle needs at speed.
        headings: whether the reference has the recorded heading, where one is known.
        floor_m: metres above home that it never goes below.

    Raises:
        MissionError: there is no such motion.
    """
    if len(recorded.time_s) < 2:
        raise MissionError("A single fix cannot be followed; choose a longer part of the recording.")
    knots = Knots.between(-LEAD_S, recorded.time_s[-1] + LEAD_S, _KNOT_STEP_S)
    ground = _ground(knots, recorded, bounds, drag)
    heights = _heights(knots, recorded, bounds, floor_m)
    known = np.isfinite(recorded.heading_deg)
    return ReferenceMotion(
        frame=recorded.frame,
        begin_s=knots.begin_s,
        end_s=knots.end_s,
        position=knots.spline(np.column_stack([ground, heights])),
        heading=knots.spline(_headings(knots, recorded, known, bounds)) if headings and known.any() else None,
    )


def _ground(knots: Knots, recorded: RecordedMotion, bounds: ReferenceBounds, drag: Drag) -> Floats:
    """Coefficients (size, 2): drag is that of the round before, until it is the same."""
    samples = Samples(*filled(recorded.time_s, recorded.position_m[:, :2]))
    rate = knots.derivative(1)
    jerk = length_bound(knots, 3, 2, bounds.jerk_m_s3)
    velocity = np.zeros((len(knots.times_s), 2))
    for _ in range(_ROUNDS):
        lean = lean_bound(knots, drag, velocity, bounds.thrust)
        coefficients = nearest_motion(knots, samples, [lean, jerk], _SMOOTHNESS_S6)
        before, velocity = velocity, rate @ coefficients
        if np.abs(velocity - before).max() < _SETTLED_M_S:
            break
    return coefficients


def _heights(knots: Knots, recorded: RecordedMotion, bounds: ReferenceBounds, floor_m: float) -> Floats:
    """Coefficients (size, 1): climb and descent have bounds of their own."""
    samples = Samples(*filled(recorded.time_s, recorded.position_m[:, 2:]))
    middle = (bounds.up_m_s - bounds.down_m_s) / 2
    return nearest_motion(
        knots,
        samples,
        [
            Bound([knots.derivative(1)], (bounds.up_m_s + bounds.down_m_s) / 2, -middle),
            length_bound(knots, 2, 1, bounds.vertical_m_s2),
            length_bound(knots, 3, 1, bounds.vertical_jerk_m_s3),
        ],
        _SMOOTHNESS_S6,
        least=floor_m,
    )


def _headings(knots: Knots, recorded: RecordedMotion, known: Flags, bounds: ReferenceBounds) -> Floats:
    """Coefficients (size, 1), the short way round from fix to fix."""
    turned = np.unwrap(recorded.heading_deg[known], period=360.0)
    samples = Samples(*filled(recorded.time_s[known], turned[:, None]))
    return nearest_motion(
        knots,
        samples,
        [length_bound(knots, 1, 1, bounds.turn_deg_s), length_bound(knots, 2, 1, bounds.turn_deg_s2)],
        _HEADING_SMOOTHNESS_S6,
    )
