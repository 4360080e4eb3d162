"""The limits of the vehicle that a route is planned for, as it reports them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import degrees, isclose

from flight_replay.planning.drag import DragModel, drag_model_of
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.parameter_names import PARAMETERS

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
    "yaw_slew_rad_s": ("turn rate", "deg/s"),
    "yaw_accel_rad_s2": ("turn acceleration", "deg/s²"),
    "mount_type": ("gimbal type", ""),
}
"""Fields of ``Limits`` that are read from the vehicle, their names and units for people."""
PARAMETER_NAMES = tuple(name for name, (limit, _) in PARAMETERS.items() if limit in _FIELDS)
"""What to read from a vehicle, in the names of all versions; each vehicle has some of them."""
_GAINS = frozenset(
    {
        "position_p",
        "velocity_p",
        "velocity_i",
        "velocity_d",
        "guided_options",
        "lean_accel_rad_s2",
        "lean_rate_rad_s",
    }
)
GAIN_NAMES = tuple(name for name, (limit, _) in PARAMETERS.items() if limit in _GAINS)
"""Those of the controllers that follow a motion, which of them GUIDED uses, and how fast it leans."""
_GAIN_WITHOUT_D = "VEL_XY_P"  # Of 3.3, whose velocity controller has no derivative.
_JERK_NAMES = frozenset(name for name, (limit, _) in PARAMETERS.items() if limit == "wp_jerk_m_s3")
_NO_JERK_LIMIT_M_S3 = 17.0
"""Before 4.1 legs had no jerk limit but that of the position controller (AC_PosControl.h)."""
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


def limits_of(parameters: Mapping[str, float], vehicle: str) -> VehicleLimits | None:
    """The limits that a vehicle's parameters set, or None where its speed is not among them.

    Args:
        parameters: those of ``PARAMETER_NAMES`` that the vehicle has, in its own units, and of its
            controllers' gains and its drag, where they are asked for.
        vehicle: its name, for people.
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
    limits = replace(limits, **{name: getattr(default, name) for name in same})
    return VehicleLimits(limits, vehicle, drag_model_of(parameters))
