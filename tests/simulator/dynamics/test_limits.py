"""Parameters of any version become the same limits in SI units."""

from __future__ import annotations

from dataclasses import fields
from math import pi, radians

import pytest

from flight_replay.simulator.dynamics.limits import GRAVITY_M_S2, Limits
from flight_replay.simulator.dynamics.parameter_names import PARAMETERS


def test_no_parameters_are_arducopter_46s_defaults() -> None:
    """An empty table gives the defaults of 4.6."""
    limits = Limits.from_parameters({})
    assert limits == Limits()
    assert (limits.wp_speed_m_s, limits.wp_accel_m_s2, limits.wp_jerk_m_s3) == (10.0, 2.5, 1.0)
    assert (limits.wp_radius_m, limits.wp_speed_up_m_s, limits.wp_speed_down_m_s) == (2.0, 2.5, 1.5)


def test_every_name_sets_a_field() -> None:
    """Each name of the table stands for a field that Limits has."""
    names = {field.name for field in fields(Limits)}
    assert {field for field, _ in PARAMETERS.values()} <= names


@pytest.mark.parametrize(
    ("old", "new", "field"),
    [
        ({"WPNAV_SPEED": 550.0}, {"WP_SPD": 5.5}, "wp_speed_m_s"),
        ({"WPNAV_ACCEL": 120.0}, {"WP_ACC": 1.2}, "wp_accel_m_s2"),
        ({"WPNAV_ACCEL_C": 300.0}, {"WP_ACC_CNR": 3.0}, "wp_accel_corner_m_s2"),
        ({"WPNAV_RADIUS": 450.0}, {"WP_RADIUS_M": 4.5}, "wp_radius_m"),
        ({"RTL_ALT": 2500.0}, {"RTL_ALT_M": 25.0}, "rtl_altitude_m"),
        ({"LAND_SPEED": 70.0}, {"LAND_SPD_MS": 0.7}, "land_speed_m_s"),
        ({"ANGLE_MAX": 4500.0}, {"ATC_ANGLE_MAX": 45.0}, "lean_angle_rad"),
        ({"PSC_ACCZ_P": 0.4}, {"PSC_D_ACC_P": 0.04}, "accel_z_p"),
    ],
)
def test_both_naming_schemes_mean_the_same(old: dict[str, float], new: dict[str, float], field: str) -> None:
    """4.6's centimetres and 4.7's metres give one value, and it is not the default."""
    before, after = Limits.from_parameters(old), Limits.from_parameters(new)
    assert getattr(before, field) == pytest.approx(getattr(after, field))
    assert getattr(before, field) != pytest.approx(getattr(Limits(), field))


def test_times_and_angles_are_converted() -> None:
    """Milliseconds become seconds, centidegrees radians."""
    limits = Limits.from_parameters({"RTL_LOIT_TIME": 2500.0, "ANGLE_MAX": 3000.0, "ATC_SLEW_YAW": 6000.0})
    assert limits.rtl_loiter_s == pytest.approx(2.5)
    assert limits.lean_angle_rad == pytest.approx(radians(30))
    assert limits.yaw_slew_rad_s == pytest.approx(radians(60))


def test_the_position_controllers_own_lean_angle_comes_first() -> None:
    """0 stands for that of the vehicle."""
    own, none = ({"PSC_ANGLE_MAX": angle, "ANGLE_MAX": 3500.0} for angle in (15.0, 0.0))
    assert Limits.from_parameters(own).lean_angle_rad == pytest.approx(radians(15))
    assert Limits.from_parameters(none).lean_angle_rad == pytest.approx(radians(35))


def test_unflyable_values_are_replaced_as_on_board() -> None:
    """No jerk means the acceleration's number, and speed, radius and acceleration have a floor."""
    limits = Limits.from_parameters({"WPNAV_JERK": 0, "WPNAV_SPEED": 1, "WPNAV_RADIUS": 1, "WPNAV_ACCEL": 0})
    assert limits.wp_accel_m_s2 == 2.5
    assert limits.wp_jerk_m_s3 == 2.5
    assert limits.wp_speed_m_s == 0.2
    assert limits.wp_radius_m == 0.05


def test_cornering_takes_twice_the_acceleration_unless_told() -> None:
    """WPNAV_ACCEL_C 0 stands for twice WPNAV_ACCEL."""
    assert Limits().corner_accel_m_s2 == 5.0
    assert Limits.from_parameters({"WPNAV_ACCEL_C": 150}).corner_accel_m_s2 == 1.5


def test_snap_follows_jerk_and_the_time_to_lean() -> None:
    """Half of jerk pi / (2 ATC_INPUT_TC), and not more than half of what the attitude can do."""
    assert Limits().path_snap_m_s4 == pytest.approx(pi / (4 * 0.15))
    assert Limits.from_parameters({"ATC_INPUT_TC": 0.3}).path_snap_m_s4 == pytest.approx(pi / (4 * 0.3))
    slow = Limits.from_parameters({"ATC_ACCEL_R_MAX": 1000, "WPNAV_JERK": 20})
    assert slow.path_snap_m_s4 == pytest.approx(0.5 * radians(10) * GRAVITY_M_S2)
    assert Limits.from_parameters({"ATC_ACCEL_R_MAX": 0}).path_snap_m_s4 == Limits().path_snap_m_s4


def test_a_limited_lean_rate_limits_jerk() -> None:
    """ATC_RATE_R_MAX caps the jerk of legs and of shaped targets."""
    slow = Limits.from_parameters({"ATC_RATE_R_MAX": 3.0, "WPNAV_JERK": 20})
    assert slow.path_jerk_m_s3 == pytest.approx(radians(3) * GRAVITY_M_S2)
    assert slow.correction_jerk_m_s3 == pytest.approx(radians(3) * GRAVITY_M_S2)


def test_shaping_jerk_is_what_lean_acceleration_allows() -> None:
    """PSC_JERK_XY holds only up to the average jerk of leaning to the full acceleration."""
    weak = Limits.from_parameters({"ATC_ACCEL_R_MAX": 1000})
    assert weak.correction_jerk_m_s3 == pytest.approx(0.5 * (2.5 * radians(10) * GRAVITY_M_S2) ** 0.5)
    assert Limits().correction_jerk_m_s3 == 5.0
    assert Limits.from_parameters({"WPNAV_ACCEL_Z": 10}).correction_jerk_z_m_s3 == pytest.approx(0.8 * pi)


def test_parameters_that_cannot_be_flown_with_fall_back() -> None:
    """Zero gains and times take the defaults, lean and hover throttle keep to their ranges."""
    zeros = Limits.from_parameters(
        dict.fromkeys(("PSC_POSXY_P", "PSC_POSZ_P", "TKOFF_SLEW_TIME", "WPNAV_SPEED_UP"), 0.0)
    )
    assert zeros == Limits()
    odd = Limits.from_parameters({"ANGLE_MAX": 100, "MOT_THST_HOVER": 0.9})
    assert odd.lean_angle_rad == pytest.approx(radians(10))
    assert odd.hover_throttle == 0.6875
