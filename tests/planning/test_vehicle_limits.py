"""The limits of a vehicle from its parameters, in the names of any version."""

from math import radians

import numpy as np
import pytest

from flight_replay.planning.vehicle_limits import FOLLOWING_NAMES, PARAMETER_NAMES, VehicleLimits, limits_of
from flight_replay.simulator.dynamics.limits import Limits

DEFAULTS_46 = {
    "WPNAV_SPEED": 1000.0,
    "WPNAV_ACCEL": 250.0,
    "WPNAV_ACCEL_C": 0.0,
    "WPNAV_JERK": 1.0,
    "WPNAV_RADIUS": 200.0,
    "WPNAV_SPEED_UP": 250.0,
    "WPNAV_SPEED_DN": 150.0,
    "WPNAV_ACCEL_Z": 100.0,
    "WP_YAW_BEHAVIOR": 2.0,
    "PSC_JERK_XY": 5.0,
    "PSC_POSXY_P": 1.0,
    "PSC_VELXY_P": 2.0,
    "PSC_VELXY_I": 1.0,
    "PSC_VELXY_D": 0.5,
    "PSC_VELXY_FLTE": 5.0,
    "PSC_VELXY_FLTD": 5.0,
    "PSC_POSZ_P": 1.0,
    "PSC_VELZ_P": 5.0,
    "ANGLE_MAX": 3000.0,
    "ATC_ACCEL_R_MAX": 110000.0,
    "ATC_RATE_R_MAX": 0.0,
    "ATC_INPUT_TC": 0.15,
}
DEFAULTS_47 = {
    "WP_SPD": 10.0,
    "WP_ACC": 2.5,
    "WP_ACC_CNR": 0.0,
    "WP_JERK": 1.0,
    "WP_RADIUS_M": 2.0,
    "WP_SPD_UP": 2.5,
    "WP_SPD_DN": 1.5,
    "WP_ACC_Z": 1.0,
    "PSC_NE_JERK": 5.0,
    "PSC_NE_POS_P": 1.0,
    "PSC_NE_VEL_P": 2.0,
    "PSC_NE_VEL_I": 1.0,
    "PSC_NE_VEL_D": 0.5,
    "PSC_NE_VEL_FLTE": 5.0,
    "PSC_NE_VEL_FLTD": 5.0,
    "PSC_D_POS_P": 1.0,
    "PSC_D_VEL_P": 5.0,
    "ATC_ANGLE_MAX": 30.0,
    "ATC_ACC_R_MAX": 1100.0,
    "ATC_RATE_R_MAX": 0.0,
    "ATC_INPUT_TC": 0.15,
}


@pytest.mark.parametrize("parameters", [DEFAULTS_46, DEFAULTS_47])
def test_the_defaults_are_exactly_the_defaults(parameters: dict[str, float]) -> None:
    """Whatever single precision makes of them: the plan made before is kept, and there is nothing to say."""
    assert set(parameters) <= set(PARAMETER_NAMES)
    received = {name: float(np.float32(value)) * (1 + 1e-7) for name, value in parameters.items()}
    found = limits_of(received, "ArduCopter")
    assert found == VehicleLimits(Limits(), "ArduCopter")
    assert found is not None
    assert found.notes == ()


@pytest.mark.parametrize(
    "changed",
    [
        DEFAULTS_46 | {"WPNAV_SPEED": 500.0, "WPNAV_SPEED_UP": 400.0, "ANGLE_MAX": 2000.0},
        DEFAULTS_47 | {"WP_SPD": 5.0, "WP_SPD_UP": 4.0, "ATC_ANGLE_MAX": 20.0},
    ],
)
def test_what_differs_is_read_and_said(changed: dict[str, float]) -> None:
    """In metres and degrees, with the default beside it."""
    found = limits_of(changed, "ArduCopter")
    assert found is not None
    assert found.limits.wp_speed_m_s == 5.0
    assert found.limits.wp_speed_up_m_s == 4.0
    assert found.limits.lean_angle_rad == pytest.approx(radians(20.0))
    (note,) = found.notes
    assert note == (
        "Planned with the vehicle's limits: speed 5 m/s (default 10), climb rate 4 m/s (default 2.5), "
        "lean angle 20 deg (default 30)."
    )
    assert found.values["lean_angle_deg"] == pytest.approx(20.0)


@pytest.mark.parametrize(
    "changed",
    [{"ATC_SLEW_YAW": 1500.0, "ATC_ACCEL_Y_MAX": 9000.0}, {"ATC_RATE_WPY_MAX": 15.0, "ATC_ACC_Y_MAX": 90.0}],
)
def test_how_fast_the_vehicle_turns_is_read_and_said(changed: dict[str, float]) -> None:
    """A heading that turns faster is not followed."""
    assert set(changed) <= set(PARAMETER_NAMES)
    found = limits_of(DEFAULTS_46 | changed, "ArduCopter")
    assert found is not None
    assert found.notes == (
        "Planned with the vehicle's limits: turn rate 15 deg/s (default 60), "
        "turn acceleration 90 deg/s² (default 270).",
    )


def test_firmware_without_a_jerk_limit_has_none() -> None:
    """ArduCopter 3.3: 5 m/s, 1 m/s², and the jerk of its position controller."""
    found = limits_of({"WPNAV_SPEED": 500.0, "WPNAV_ACCEL": 100.0}, "ArduCopter 3.3.0")
    assert found is not None
    assert (found.limits.wp_speed_m_s, found.limits.wp_accel_m_s2) == (5.0, 1.0)
    assert found.limits.wp_jerk_m_s3 == 17.0
    assert found.limits.wp_speed_up_m_s == 2.5


def test_a_vehicle_that_tells_no_speed_has_unknown_limits() -> None:
    """Nothing, or too little, arrived."""
    assert limits_of({}, "ArduCopter") is None
    assert limits_of({"WPNAV_ACCEL": 100.0}, "ArduCopter") is None


def test_corner_acceleration_is_told_as_it_is_used() -> None:
    """0 stands for twice the acceleration."""
    assert VehicleLimits().values["accel_corner_m_s2"] == 5.0
    found = limits_of(DEFAULTS_46 | {"WPNAV_ACCEL": 100.0}, "ArduCopter")
    assert found is not None
    assert found.values["accel_corner_m_s2"] == 2.0


def test_what_a_lossy_link_delivers_first_does_not_matter() -> None:
    """The drag's parameters may come before those of the speed, or without them."""
    found = limits_of({"EK3_DRAG_BCOEF_X": 0.0, "WPNAV_SPEED": 500.0}, "ArduCopter")
    assert found is not None
    assert found.limits.wp_speed_m_s == 5.0
    assert limits_of({"EK3_DRAG_BCOEF_X": 0.0}, "ArduCopter") is None


@pytest.mark.parametrize(
    "changed",
    [{"PSC_VELXY_D": 0.25, "ATC_INPUT_TC": 0.3}, {"PSC_NE_VEL_D": 0.25, "ATC_INPUT_TC": 0.3}],
)
def test_how_closely_the_vehicle_follows_its_targets_is_read_and_said(changed: dict[str, float]) -> None:
    """Missions take longer or shorter by it: 4.7 has half of the derivative gain that 4.6 has."""
    assert set(changed) <= set(PARAMETER_NAMES)
    found = limits_of({"WPNAV_SPEED": 1000.0, "WPNAV_JERK": 1.0} | changed, "ArduCopter")
    assert found is not None
    assert found.notes == (
        "Planned with the vehicle's limits: lean time 0.3 s (default 0.15), "
        "derivative velocity gain 0.25 (default 0.5).",
    )


@pytest.mark.parametrize(
    ("told_hz", "taken_hz"), [(2.0, 2.0), (0.2, 1.0), (0.0, 100.0)], ids=["slow", "too slow", "none"]
)
@pytest.mark.parametrize("name", ["PSC_VELXY_{}", "PSC_NE_VEL_{}"])
def test_the_filters_of_the_velocity_controller_are_read(name: str, told_hz: float, taken_hz: float) -> None:
    """The slower they are, the later the vehicle follows; 0 is none."""
    filters = {name.format("FLTE"): told_hz, name.format("FLTD"): told_hz}
    assert set(filters) <= set(PARAMETER_NAMES)
    found = limits_of(DEFAULTS_46 | filters, "ArduCopter")
    assert found is not None
    assert (found.limits.velocity_error_hz, found.limits.velocity_d_hz) == (taken_hz, taken_hz)


def test_gains_beyond_those_that_the_model_is_steady_with_count_as_the_nearest() -> None:
    """A plan for a model that shakes would be none."""
    found = limits_of(DEFAULTS_46 | {"PSC_VELXY_P": 50.0, "PSC_VELXY_D": -3.0}, "ArduCopter")
    assert found is not None
    assert (found.limits.velocity_p, found.limits.velocity_d) == (6.0, 0.0)


def test_the_gains_of_every_version_are_read() -> None:
    """Those of 3.3 have other names, and no derivative."""
    old = {"WPNAV_SPEED": 500.0, "POS_XY_P": 1.5, "VEL_XY_P": 1.2, "VEL_XY_I": 0.6}
    assert {"POS_XY_P", "PSC_POSXY_P", "PSC_NE_POS_P", "PSC_VELXY_D"} <= set(FOLLOWING_NAMES)
    found = limits_of(old, "ArduCopter")
    assert found is not None
    limits = found.limits
    gains = (limits.position_p, limits.velocity_p, limits.velocity_i, limits.velocity_d)
    assert gains == (1.5, 1.2, 0.6, 0.0)
    new = limits_of(DEFAULTS_46 | {"PSC_VELXY_D": 0.25}, "ArduCopter")
    assert new is not None
    assert (new.limits.velocity_p, new.limits.velocity_d) == (2.0, 0.25)


@pytest.mark.parametrize(
    ("version", "late"),
    [
        ((0,), False),
        ((3, 3, 0, 255), False),
        ((4, 6, 0, 0), False),
        ((4, 6, 0, 255), True),
        ((4, 7, 0, 0), True),
    ],
)
def test_corners_are_those_of_the_firmware(version: tuple[int, ...], late: bool) -> None:
    """No parameter tells of them; of 4.6.0 its development versions have those of before."""
    found = limits_of(DEFAULTS_46, "ArduCopter", version)
    assert found is not None
    assert bool(found.limits.late_corners) is late
    assert found.notes == ()
