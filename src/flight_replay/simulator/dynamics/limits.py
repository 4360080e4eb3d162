"""What ArduCopter's parameters allow the copter to do, in SI units.

Defaults are those of ArduCopter 4.6. ``Limits.from_parameters`` reads a parameter table in
ArduPilot's own names and units: those of 3.3 to 4.6 (``WPNAV_SPEED`` in cm/s) and those that 4.7
renamed and rescaled (``WP_SPD`` in m/s).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import pi, sqrt
from typing import Final

from flight_replay.simulator.dynamics.parameter_names import NONE_IF_ZERO, PARAMETERS
from flight_replay.simulator.dynamics.shaping import clamp

GRAVITY_M_S2: Final = 9.80665
_DEG: Final = pi / 180.0
# AC_WPNav.cpp: WPNAV_WP_SPEED_MIN and WPNAV_WP_RADIUS_MIN.
MIN_SPEED_M_S: Final = 0.2
MIN_RADIUS_M: Final = 0.05
# Parameters.cpp: the range of ANGLE_MAX; AP_MotorsMulticopter.cpp: AP_MOTORS_THST_HOVER_MIN and _MAX.
_LEAN_ANGLES_RAD = (10.0 * _DEG, 80.0 * _DEG)
_HOVER_THROTTLES = (0.125, 0.6875)
# LowPassFilter.cpp: a filter of 0 Hz passes everything on.
_UNFILTERED_HZ = 1000.0
# Parameters of which ArduCopter refuses or ignores values that are not above zero.
_POSITIVE = (
    "wp_accel_m_s2",
    "wp_accel_z_m_s2",
    "wp_speed_up_m_s",
    "wp_speed_down_m_s",
    "position_p",
    "position_z_p",
    "velocity_z_p",
    "shaping_jerk_m_s3",
    "shaping_jerk_z_m_s3",
    "takeoff_slew_s",
)


@dataclass(frozen=True, slots=True)
class Limits:
    """Speeds m/s, accelerations m/s², jerk m/s³, lengths m, times s, filters Hz, angles rad, turns rad/s."""

    wp_speed_m_s: float = 10.0
    wp_accel_m_s2: float = 2.5
    wp_accel_corner_m_s2: float = 0.0
    wp_jerk_m_s3: float = 1.0
    wp_radius_m: float = 2.0
    wp_speed_up_m_s: float = 2.5
    wp_speed_down_m_s: float = 1.5
    wp_accel_z_m_s2: float = 1.0
    wp_yaw_behavior: float = 2.0
    rtl_altitude_m: float = 15.0
    rtl_altitude_final_m: float = 0.0
    rtl_climb_min_m: float = 0.0
    rtl_cone_slope: float = 3.0
    rtl_speed_m_s: float = 0.0
    rtl_loiter_s: float = 5.0
    land_speed_m_s: float = 0.5
    land_speed_high_m_s: float = 0.0
    land_altitude_low_m: float = 10.0
    position_p: float = 1.0
    velocity_p: float = 2.0
    velocity_i: float = 1.0
    velocity_d: float = 0.5
    velocity_error_hz: float = 5.0
    velocity_d_hz: float = 5.0
    shaping_jerk_m_s3: float = 5.0
    position_z_p: float = 1.0
    velocity_z_p: float = 5.0
    accel_z_p: float = 0.5
    accel_z_i: float = 1.0
    shaping_jerk_z_m_s3: float = 5.0
    lean_angle_rad: float = 30.0 * _DEG
    attitude_input_s: float = 0.15
    lean_accel_rad_s2: float = 1100.0 * _DEG
    lean_rate_rad_s: float = 0.0
    yaw_accel_rad_s2: float = 270.0 * _DEG
    yaw_slew_rad_s: float = 60.0 * _DEG
    hover_throttle: float = 0.39
    spool_s: float = 0.5
    takeoff_slew_s: float = 2.0
    takeoff_throttle_max: float = 0.9
    arming_delay_s: float = 2.0
    circle_radius_m: float = 10.0
    circle_rate_rad_s: float = 20.0 * _DEG
    guided_timeout_s: float = 3.0
    guided_options: float = 0.0
    mount_type: float = 0.0
    """A gimbal turns to what is to be faced instead of the vehicle; 0 is none."""
    late_corners: float = 0.0
    """1 where corners between straight legs are those of released 4.6 and later, else 0: ``leg_blending``."""

    @classmethod
    def from_parameters(cls, parameters: Mapping[str, float]) -> Limits:
        """The limits that a parameter table sets; parameters that are absent keep their defaults.

        Args:
            parameters: ArduPilot names to values in ArduPilot's units, of any version from 3.3 to 4.7.
        """
        limits = cls()
        for name, (field, scale) in PARAMETERS.items():
            if name in parameters and (name not in NONE_IF_ZERO or parameters[name] > 0):
                limits = replace(limits, **{field: float(parameters[name]) * scale})
        return limits._with_valid_values()

    def _with_valid_values(self) -> Limits:
        """The limits with invalid values replaced or bounded as on board."""
        default = Limits()
        valid = {name: getattr(self, name) for name in _POSITIVE if getattr(self, name) > 0}
        limits = replace(self, **{name: valid.get(name, getattr(default, name)) for name in _POSITIVE})
        return replace(
            limits,
            wp_speed_m_s=max(self.wp_speed_m_s, MIN_SPEED_M_S),
            wp_radius_m=max(self.wp_radius_m, MIN_RADIUS_M),
            wp_jerk_m_s3=self.wp_jerk_m_s3 if self.wp_jerk_m_s3 > 0 else limits.wp_accel_m_s2,
            velocity_error_hz=self.velocity_error_hz if self.velocity_error_hz > 0 else _UNFILTERED_HZ,
            velocity_d_hz=self.velocity_d_hz if self.velocity_d_hz > 0 else _UNFILTERED_HZ,
            lean_angle_rad=clamp(self.lean_angle_rad, *_LEAN_ANGLES_RAD),
            hover_throttle=clamp(self.hover_throttle, *_HOVER_THROTTLES),
        )

    @property
    def corner_accel_m_s2(self) -> float:
        """Most acceleration in a corner (AC_WPNav::get_corner_acceleration)."""
        return self.wp_accel_corner_m_s2 if self.wp_accel_corner_m_s2 > 0 else 2.0 * self.wp_accel_m_s2

    @property
    def path_jerk_m_s3(self) -> float:
        """Jerk of straight legs (AC_WPNav::calc_scurve_jerk_and_snap)."""
        by_rate = self.lean_rate_rad_s * GRAVITY_M_S2
        return min(self.wp_jerk_m_s3, by_rate) if by_rate > 0 else self.wp_jerk_m_s3

    @property
    def path_snap_m_s4(self) -> float:
        """Snap of straight legs: half of what leaning allows (AC_WPNav::calc_scurve_jerk_and_snap)."""
        snap = self.path_jerk_m_s3 * pi / (2.0 * max(self.attitude_input_s, 0.1))
        by_accel = self.lean_accel_rad_s2 * GRAVITY_M_S2
        return 0.5 * (min(snap, by_accel) if by_accel > 0 else snap)

    @property
    def correction_jerk_m_s3(self) -> float:
        """Jerk of shaped horizontal targets (AC_PosControl::set_max_speed_accel_xy)."""
        jerk = self.shaping_jerk_m_s3
        if self.lean_rate_rad_s > 0:
            jerk = min(jerk, self.lean_rate_rad_s * GRAVITY_M_S2)
        if self.lean_accel_rad_s2 > 0:
            jerk = min(jerk, 0.5 * sqrt(self.wp_accel_m_s2 * self.lean_accel_rad_s2 * GRAVITY_M_S2))
        return jerk

    @property
    def correction_jerk_z_m_s3(self) -> float:
        """Jerk of shaped vertical targets (AC_PosControl::set_max_speed_accel_z, 20 Hz throttle filter)."""
        return min(self.shaping_jerk_z_m_s3, min(GRAVITY_M_S2, self.wp_accel_z_m_s2) * 8.0 * pi)
