"""What ArduCopter's parameters allow the copter to do, in SI units.

Defaults are those of ArduCopter 4.6. ``Limits.from_parameters`` reads a parameter table in
ArduPilot's own names and units: those of 3.3 to 4.6 (``WPNAV_SPEED`` in cm/s) and those that 4.7
renamed and rescaled (``WP_SPD`` in m/s).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import pi, sqrt

GRAVITY_M_S2 = 9.80665
_CENTI = 0.01
_MILLI = 0.001
_CENTI_DEG = pi / 18000.0
_DEG = pi / 180.0
# AC_WPNav.cpp: WPNAV_WP_SPEED_MIN and WPNAV_WP_RADIUS_MIN.
MIN_SPEED_M_S = 0.2
MIN_RADIUS_M = 0.05


@dataclass(frozen=True, slots=True)
class Limits:
    """Speeds m/s, accelerations m/s², jerk m/s³, lengths m, times s, angles rad, yaw rates rad/s."""

    wp_speed_m_s: float = 10.0
    wp_accel_m_s2: float = 2.5
    wp_accel_corner_m_s2: float = 0.0
    wp_jerk_m_s3: float = 1.0
    wp_radius_m: float = 2.0
    wp_speed_up_m_s: float = 2.5
    wp_speed_down_m_s: float = 1.5
    wp_accel_z_m_s2: float = 1.0
    wp_yaw_behavior: int = 2
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

    @classmethod
    def from_parameters(cls, parameters: Mapping[str, float]) -> Limits:
        """The limits that a parameter table sets; parameters that are absent keep their defaults.

        Args:
            parameters: ArduPilot names to values in ArduPilot's units, of any version from 3.3 to 4.7.
        """
        values = {}
        for name, (field, scale) in PARAMETERS.items():
            if name in parameters:
                values[field] = float(parameters[name]) * scale
        limits = cls(**{f.name: values.get(f.name, f.default) for f in fields(cls)})
        return limits._made_flyable()

    def _made_flyable(self) -> Limits:
        """Values that ArduCopter replaces when it starts to navigate (AC_WPNav::wp_and_spline_init)."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        values["wp_speed_m_s"] = max(self.wp_speed_m_s, MIN_SPEED_M_S)
        values["wp_radius_m"] = max(self.wp_radius_m, MIN_RADIUS_M)
        values["wp_accel_m_s2"] = self.wp_accel_m_s2 if self.wp_accel_m_s2 > 0 else 2.5
        values["wp_jerk_m_s3"] = self.wp_jerk_m_s3 if self.wp_jerk_m_s3 > 0 else values["wp_accel_m_s2"]
        values["wp_yaw_behavior"] = int(self.wp_yaw_behavior)
        return Limits(**values)

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


PARAMETERS: dict[str, tuple[str, float]] = {
    # Names and units up to 4.6, then 4.7's; a table holds one or the other.
    "WPNAV_SPEED": ("wp_speed_m_s", _CENTI),
    "WPNAV_ACCEL": ("wp_accel_m_s2", _CENTI),
    "WPNAV_ACCEL_C": ("wp_accel_corner_m_s2", _CENTI),
    "WPNAV_JERK": ("wp_jerk_m_s3", 1.0),
    "WPNAV_RADIUS": ("wp_radius_m", _CENTI),
    "WPNAV_SPEED_UP": ("wp_speed_up_m_s", _CENTI),
    "WPNAV_SPEED_DN": ("wp_speed_down_m_s", _CENTI),
    "WPNAV_ACCEL_Z": ("wp_accel_z_m_s2", _CENTI),
    "WP_YAW_BEHAVIOR": ("wp_yaw_behavior", 1.0),
    "RTL_ALT": ("rtl_altitude_m", _CENTI),
    "RTL_ALT_FINAL": ("rtl_altitude_final_m", _CENTI),
    "RTL_CLIMB_MIN": ("rtl_climb_min_m", _CENTI),
    "RTL_CONE_SLOPE": ("rtl_cone_slope", 1.0),
    "RTL_SPEED": ("rtl_speed_m_s", _CENTI),
    "RTL_LOIT_TIME": ("rtl_loiter_s", _MILLI),
    "LAND_SPEED": ("land_speed_m_s", _CENTI),
    "LAND_SPEED_HIGH": ("land_speed_high_m_s", _CENTI),
    "LAND_ALT_LOW": ("land_altitude_low_m", _CENTI),
    "PSC_POSXY_P": ("position_p", 1.0),
    "PSC_VELXY_P": ("velocity_p", 1.0),
    "PSC_VELXY_I": ("velocity_i", 1.0),
    "PSC_VELXY_D": ("velocity_d", 1.0),
    "PSC_JERK_XY": ("shaping_jerk_m_s3", 1.0),
    "PSC_POSZ_P": ("position_z_p", 1.0),
    "PSC_VELZ_P": ("velocity_z_p", 1.0),
    "PSC_ACCZ_P": ("accel_z_p", 1.0),
    "PSC_ACCZ_I": ("accel_z_i", 1.0),
    "PSC_JERK_Z": ("shaping_jerk_z_m_s3", 1.0),
    "ANGLE_MAX": ("lean_angle_rad", _CENTI_DEG),
    "ATC_INPUT_TC": ("attitude_input_s", 1.0),
    "ATC_ACCEL_R_MAX": ("lean_accel_rad_s2", _CENTI_DEG),
    "ATC_RATE_R_MAX": ("lean_rate_rad_s", _DEG),
    "ATC_ACCEL_Y_MAX": ("yaw_accel_rad_s2", _CENTI_DEG),
    "ATC_SLEW_YAW": ("yaw_slew_rad_s", _CENTI_DEG),
    "MOT_THST_HOVER": ("hover_throttle", 1.0),
    "MOT_SPOOL_TIME": ("spool_s", 1.0),
    "TKOFF_SLEW_TIME": ("takeoff_slew_s", 1.0),
    "TKOFF_THR_MAX": ("takeoff_throttle_max", 1.0),
    "CIRCLE_RADIUS": ("circle_radius_m", _CENTI),
    "CIRCLE_RATE": ("circle_rate_rad_s", _DEG),
    "WP_SPD": ("wp_speed_m_s", 1.0),
    "WP_ACC": ("wp_accel_m_s2", 1.0),
    "WP_ACC_CNR": ("wp_accel_corner_m_s2", 1.0),
    "WP_JERK": ("wp_jerk_m_s3", 1.0),
    "WP_RADIUS_M": ("wp_radius_m", 1.0),
    "WP_SPD_UP": ("wp_speed_up_m_s", 1.0),
    "WP_SPD_DN": ("wp_speed_down_m_s", 1.0),
    "WP_ACC_Z": ("wp_accel_z_m_s2", 1.0),
    "RTL_ALT_M": ("rtl_altitude_m", 1.0),
    "RTL_ALT_FINAL_M": ("rtl_altitude_final_m", 1.0),
    "RTL_CLIMB_MIN_M": ("rtl_climb_min_m", 1.0),
    "RTL_SPEED_MS": ("rtl_speed_m_s", 1.0),
    "LAND_SPD_MS": ("land_speed_m_s", 1.0),
    "LAND_SPD_HIGH_MS": ("land_speed_high_m_s", 1.0),
    "LAND_ALT_LOW_M": ("land_altitude_low_m", 1.0),
    "CIRCLE_RADIUS_M": ("circle_radius_m", 1.0),
}
"""ArduPilot parameter names to the field that they set and its SI units per unit of theirs."""
