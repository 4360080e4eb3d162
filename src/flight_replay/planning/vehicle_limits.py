"""The limits of the vehicle that a route is planned for, as it reports them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import degrees, isclose

from flight_replay.planning.drag import PARAMETER_NAMES as DRAG_NAMES
from flight_replay.planning.drag import DragModel, drag_model_of
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.parameter_names import PARAMETERS
from flight_replay.simulator.dynamics.shaping import clamp

_FIELDS: dict[str, tuple[str, str]] = {
    "wp_speed_m_s": ("speed", "m/s"),
    "wp_accel_m_s2": ("acceleration", "m/s²"),
    "wp_accel_corner_m_s2": ("corner acceleration", "m/s²"),
    "wp_jerk_m_s3": ("jerk", "m/s³"),
    "wp_radius_m": ("waypoint radius", "m"),
    "wp_speed_up_m_s": ("climb rate", "m/s"),
    "wp_speed_down_m_s": ("descent rate", "m/s"),
    "wp_accel_z_m_s2": ("vertical acceleration", "m/s²"),
    "wp_yaw_behavior": ("yaw behaviour", ""),
    "shaping_jerk_m_s3": ("controller jerk", "m/s³"),
    "lean_angle_rad": ("lean angle", "deg"),
    "lean_accel_rad_s2": ("lean acceleration", "deg/s²"),
    "lean_rate_rad_s": ("lean rate", "deg/s"),
    "attitude_input_s": ("lean time", "s"),
    "position_p": ("position gain", "1/s"),
    "velocity_p": ("velocity gain", "1/s"),
    "velocity_i": ("integral velocity gain", "1/s²"),
    "velocity_d": ("derivative velocity gain", ""),
    "velocity_error_hz": ("velocity error filter", "Hz"),
    "velocity_d_hz": ("derivative velocity filter", "Hz"),
    "position_z_p": ("vertical position gain", "1/s"),
    "velocity_z_p": ("vertical velocity gain", "1/s"),
    "yaw_slew_rad_s": ("turn rate", "deg/s"),
    "yaw_accel_rad_s2": ("turn acceleration", "deg/s²"),
    "mount_type": ("gimbal type", ""),
}
"""Fields of ``Limits`` that are read from the vehicle, their names and units for people."""
_GAIN_WITHOUT_D = "VEL_XY_P"  # Of 3.3, whose velocity controller has no derivative.
_OLD_GAINS = ("POS_XY_P", _GAIN_WITHOUT_D, "VEL_XY_I")
"""Of 3.3, too, whose legs are led by a leash: with them the model of its missions is no nearer."""
PARAMETER_NAMES = tuple(
    name for name, (limit, _) in PARAMETERS.items() if limit in _FIELDS and name not in _OLD_GAINS
)
"""What to read from a vehicle, in the names of all versions; each vehicle has some of them."""
FOLLOWING_NAMES = (*PARAMETER_NAMES, *_OLD_GAINS, "GUID_OPTIONS", *DRAG_NAMES)
"""What to read where the recording is followed."""
_TRUSTED = {
    "position_p": (0.25, 3.0),
    "velocity_p": (0.1, 6.0),
    "velocity_i": (0.0, 3.0),
    "velocity_d": (0.0, 1.5),
    "velocity_error_hz": (1.0, 100.0),
    "velocity_d_hz": (1.0, 100.0),
    "position_z_p": (0.25, 3.0),
    "velocity_z_p": (1.0, 8.0),
    "attitude_input_s": (0.0, 1.0),
}
"""The gains with which the model is steady: all that AC_PosControl.cpp has for their ranges, and more."""
_JERK_NAMES = frozenset(name for name, (limit, _) in PARAMETERS.items() if limit == "wp_jerk_m_s3")
_NO_JERK_LIMIT_M_S3 = 17.0
"""Before 4.1 legs had no jerk limit but that of the position controller (AC_PosControl.h)."""
_LATE_CORNERS = (4, 6, 0, 128)
"""A beta of 4.6.0; the sixth was the first with such corners."""
_SAME = 1e-5
"""Relative: parameters are float32."""


@dataclass(frozen=True, slots=True)
class VehicleLimits:
    """``limits`` of ``vehicle``; without a vehicle they are the defaults of ArduCopter 4.6.

    ``drag`` is what its parameters tell of its drag, None where they do not.
    """

    limits: Limits = field(default_factory=Limits)
    vehicle: str | None = None
    drag: DragModel | None = None

    @property
    def notes(self) -> tuple[str, ...]:
        """A sentence on the limits that are not the defaults, if any."""
        told = [
            f"{name} {_value(self.limits, limit):.4g} {unit}".rstrip()
            + f" (default {_value(Limits(), limit):.4g})"
            for limit, (name, unit) in _FIELDS.items()
            if getattr(self.limits, limit) != getattr(Limits(), limit)
        ]
        return (f"Planned with the vehicle's limits: {', '.join(told)}.",) if told else ()

    @property
    def values(self) -> dict[str, float]:
        """The limits by name and unit: m/s, m/s², m/s³, m and degrees."""
        names = {name: name.removeprefix("wp_").replace("_rad", "_deg") for name in _FIELDS}
        return {names[limit]: _value(self.limits, limit) for limit in _FIELDS}


def _value(limits: Limits, limit: str) -> float:
    """A limit as people are told it; 0 as corner acceleration stands for twice the acceleration."""
    if limit == "wp_accel_corner_m_s2":
        return limits.corner_accel_m_s2
    value = float(getattr(limits, limit))
    return degrees(value) if limit.endswith(("_rad", "_rad_s", "_rad_s2")) else value


def limits_of(
    parameters: Mapping[str, float], vehicle: str, version: tuple[int, ...] = ()
) -> VehicleLimits | None:
    """The limits that a vehicle's parameters set, or None where its speed is not among them.

    Args:
        parameters: those of ``PARAMETER_NAMES`` or ``FOLLOWING_NAMES`` that it has, in its own units.
        vehicle: its name, for people.
        version: of its firmware, then ``Identity.maturity``, such as (4, 6, 0, 255); empty where unknown.
    """
    known = {name: value for name, value in parameters.items() if name in PARAMETERS}
    if not any(PARAMETERS[name][0] == "wp_speed_m_s" for name in known):
        return None
    if _JERK_NAMES.isdisjoint(known):
        known["WPNAV_JERK"] = _NO_JERK_LIMIT_M_S3
    if _GAIN_WITHOUT_D in known:
        known["PSC_VELXY_D"] = 0.0
    limits, default = Limits.from_parameters(known), Limits()
    same = [name for name in _FIELDS if isclose(getattr(limits, name), getattr(default, name), rel_tol=_SAME)]
    bounded = {name: clamp(getattr(limits, name), *ends) for name, ends in _TRUSTED.items()}
    limits = replace(limits, **bounded | {name: getattr(default, name) for name in same})
    limits = replace(limits, late_corners=float(version >= _LATE_CORNERS))
    return VehicleLimits(limits, vehicle, drag_model_of(parameters))
