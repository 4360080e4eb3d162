"""ArduPilot's names of what ``Limits`` holds, and the factors that turn its units into SI.

Names and units up to 4.6, then those of 3.3 that differ, then those of 4.7 (ardupilot pull requests 31970,
32147, 32186, 32192 and the position controller's); a vehicle has one or the other.
"""

from __future__ import annotations

from math import pi

_CENTI = 0.01
_MILLI = 0.001
_DEG = pi / 180.0
_CENTI_DEG = _CENTI * _DEG

PARAMETERS: dict[str, tuple[str, float]] = {
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
    "PSC_VELXY_FLTE": ("velocity_error_hz", 1.0),
    "PSC_VELXY_FLTD": ("velocity_d_hz", 1.0),
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
    "GUID_TIMEOUT": ("guided_timeout_s", 1.0),
    "GUID_OPTIONS": ("guided_options", 1.0),
    "MNT1_TYPE": ("mount_type", 1.0),
    # 3.3
    "MNT_TYPE": ("mount_type", 1.0),
    "POS_XY_P": ("position_p", 1.0),
    "VEL_XY_P": ("velocity_p", 1.0),
    "VEL_XY_I": ("velocity_i", 1.0),
    # 4.7
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
    "PSC_NE_POS_P": ("position_p", 1.0),
    "PSC_NE_VEL_P": ("velocity_p", 1.0),
    "PSC_NE_VEL_I": ("velocity_i", 1.0),
    "PSC_NE_VEL_D": ("velocity_d", 1.0),
    "PSC_NE_VEL_FLTE": ("velocity_error_hz", 1.0),
    "PSC_NE_VEL_FLTD": ("velocity_d_hz", 1.0),
    "PSC_JERK_NE": ("shaping_jerk_m_s3", 1.0),
    "PSC_NE_JERK": ("shaping_jerk_m_s3", 1.0),
    "PSC_D_POS_P": ("position_z_p", 1.0),
    "PSC_D_VEL_P": ("velocity_z_p", 1.0),
    "PSC_D_ACC_P": ("accel_z_p", 10.0),
    "PSC_D_ACC_I": ("accel_z_i", 10.0),
    "PSC_JERK_D": ("shaping_jerk_z_m_s3", 1.0),
    "PSC_D_JERK": ("shaping_jerk_z_m_s3", 1.0),
    "ATC_ANGLE_MAX": ("lean_angle_rad", _DEG),
    "ATC_ACC_R_MAX": ("lean_accel_rad_s2", _DEG),
    "ATC_ACC_Y_MAX": ("yaw_accel_rad_s2", _DEG),
    "ATC_RATE_WPY_MAX": ("yaw_slew_rad_s", _DEG),
    # From 3.6 on, instead of what comes before.
    "PSC_ANGLE_MAX": ("lean_angle_rad", _DEG),
}
"""Name: field of ``Limits``, and its value per unit of the parameter."""
NONE_IF_ZERO = frozenset({"PSC_ANGLE_MAX"})
"""Parameters of which 0 leaves the field as another has it (AC_PosControl::get_lean_angle_max_cd)."""
