"""The target heading (ArduCopter/autoyaw.cpp and AC_PosControl::calculate_yaw_and_rate_yaw)."""

from __future__ import annotations

from enum import Enum
from math import atan2, pi, radians
from typing import Final

from flight_replay.simulator.dynamics.airframe import Airframe
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.position_control import PositionControl
from flight_replay.simulator.dynamics.shaping import clamp, wrap_pi
from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.dynamics.vector import norm

# WP_YAW_BEHAVIOR.
_NEVER: Final = 0
_NEXT_WAYPOINT: Final = 1
_NEXT_WAYPOINT_EXCEPT_RTL: Final = 2
_AHEAD: Final = 3
# AC_PosControl.cpp turns the target only above this share of the highest speed.
_TURNING_SHARE: Final = 0.05
# autoyaw.cpp: YAW_LOOK_AHEAD_MIN_SPEED, 1 m/s.
_LOOK_AHEAD_SPEED_M_S: Final = 1.0
_REACHED_RAD: Final = radians(2.0)


class YawMode(Enum):
    """What the target heading follows (AutoYaw::Mode)."""

    HOLD = "the present heading"
    LOOK_AT_NEXT_WP = "the target's path"
    LOOK_AHEAD = "the flown path"
    FIXED = "a given heading"
    ANGLE_RATE = "a heading that turns"
    RATE = "a yaw rate"
    ROI = "a position to face"


class AutoYaw(SnapshotPart):
    """The target heading; ``update`` turns the airframe one step towards it."""

    def __init__(self, limits: Limits, airframe: Airframe, control: PositionControl) -> None:
        self._limits, self._airframe, self._control = limits, airframe, control
        self.mode = YawMode.HOLD
        self.target_rad = self.armed_yaw_rad = airframe.yaw
        self._remaining_rad = 0.0
        self._slew_rad_s = self._rate_rad_s = 0.0
        self._roi_m = 0.0, 0.0

    def use_limits(self, limits: Limits) -> None:
        """Use other limits from now on."""
        self._limits = limits

    def hold(self) -> None:
        """Hold the present heading."""
        self.mode = YawMode.HOLD
        self.target_rad = self._airframe.heading.target

    def set_default_mode(self, *, returning: bool = False) -> None:
        """Choose the mode by WP_YAW_BEHAVIOR (AutoYaw::default_mode)."""
        behavior = self._limits.wp_yaw_behavior
        if behavior == _NEVER or (behavior == _NEXT_WAYPOINT_EXCEPT_RTL and returning):
            self.mode = YawMode.HOLD
        elif behavior == _AHEAD:
            self.mode = YawMode.LOOK_AHEAD
        else:
            self.mode = YawMode.LOOK_AT_NEXT_WP

    def begin_mission(self) -> None:
        """Face no position of an earlier run (ModeAuto::init)."""
        if self.mode is YawMode.ROI:
            self.hold()

    def begin_leg(self, *, keeps_heading: bool = False) -> None:
        """Choose the mode for a leg: a position is faced on (ModeAuto::wp_start, do_spline_wp)."""
        if self.mode is YawMode.ROI:
            return
        if keeps_heading:
            self.hold()
        else:
            self.set_default_mode()

    def face(self, north_east_m: tuple[float, float]) -> None:
        """Face a position, north and east of home, from wherever the vehicle is (AutoYaw::set_roi)."""
        self.mode = YawMode.ROI
        self._roi_m = north_east_m

    def set_fixed_yaw(
        self, angle_rad: float, rate_rad_s: float = 0.0, direction: float = 0.0, *, relative: bool = False
    ) -> None:
        """Turn to an angle, or by one (AutoYaw::set_fixed_yaw)."""
        if relative:
            self._remaining_rad = angle_rad * (1.0 if direction >= 0 else -1.0)
        else:
            self._remaining_rad = wrap_pi(angle_rad - self.target_rad)
            if direction * self._remaining_rad < 0:
                self._remaining_rad += 2 * pi if direction > 0 else -2 * pi
        slew = self._limits.yaw_slew_rad_s
        self._slew_rad_s = min(slew, rate_rad_s) if rate_rad_s > 0 else slew
        self.mode = YawMode.FIXED

    def set_yaw_and_rate(self, yaw_rad: float, rate_rad_s: float) -> None:
        """Turn to a heading, at any rate up to the slew limit, and go on from it with a rate."""
        self.mode = YawMode.ANGLE_RATE
        self.target_rad, self._rate_rad_s = yaw_rad, rate_rad_s

    def set_rate(self, rate_rad_s: float) -> None:
        """Turn with a rate, whatever the heading."""
        self.mode = YawMode.RATE
        self._rate_rad_s = rate_rad_s

    def stop_turning(self) -> None:
        """Brake a turn with a rate, and hold the heading that it ends at."""
        if self.mode in (YawMode.RATE, YawMode.ANGLE_RATE):
            self.set_rate(0.0)

    def look_at(self, position_m: tuple[float, float]) -> None:
        """Turn one step towards a position, as in circles, unless another one is faced."""
        if self.mode is not YawMode.ROI:
            self.mode = YawMode.HOLD
            self.target_rad = self._bearing_rad(position_m)
        self.update()

    def reset_to_armed_yaw(self) -> None:
        """Turn to the heading that the vehicle was armed with (RESETTOARMEDYAW)."""
        self.mode = YawMode.HOLD
        self._remaining_rad = 0.0
        self.target_rad = self.armed_yaw_rad

    @property
    def holds_in_rtl(self) -> bool:
        """Whether RTL keeps the heading (AutoYaw::default_mode)."""
        return self._limits.wp_yaw_behavior in (_NEVER, _NEXT_WAYPOINT_EXCEPT_RTL)

    def resume_fixed_yaw(self) -> None:
        """Go on turning to a fixed heading, even if the mode has changed since (ModeAuto::verify_yaw)."""
        self.mode = YawMode.FIXED

    @property
    def reached(self) -> bool:
        """Whether a fixed heading is reached, within 2 degrees (AutoYaw::reached_fixed_yaw_target)."""
        error = wrap_pi(self.target_rad - self._airframe.yaw)
        return self._remaining_rad == 0 and abs(error) <= _REACHED_RAD

    def update(self) -> None:
        """Turn the airframe one step."""
        if self.mode is YawMode.FIXED:
            step = self._slew_rad_s * self._control.dt
            step = clamp(self._remaining_rad, -step, step)
            self._remaining_rad -= step
            self.target_rad += step
        elif self.mode is YawMode.RATE:
            self._airframe.turn_at(self._rate_rad_s)
            self.target_rad = self._airframe.heading.target
            return
        rate = self.update_target()
        self._airframe.turn_towards(self.target_rad, rate)
        if self.mode is YawMode.ANGLE_RATE:
            self.target_rad += rate * self._control.dt

    def update_target(self) -> float:
        """Take the heading that the mode follows, if it follows one; returns its yaw rate."""
        airframe = self._airframe
        if self.mode is YawMode.LOOK_AT_NEXT_WP:
            return self._along_target()
        if self.mode is YawMode.ANGLE_RATE:
            return self._rate_rad_s
        if self.mode is YawMode.ROI:
            self.target_rad = self._bearing_rad(self._roi_m)
        if self.mode is YawMode.LOOK_AHEAD and norm(airframe.vn, airframe.ve) > _LOOK_AHEAD_SPEED_M_S:
            self.target_rad = atan2(airframe.ve, airframe.vn)
        return 0.0

    def _bearing_rad(self, position_m: tuple[float, float]) -> float:
        return atan2(position_m[1] - self._airframe.e, position_m[0] - self._airframe.n)

    @property
    def course_rad(self) -> float | None:
        """Where the target's velocity points; None below 5 % of the highest speed."""
        return atan2(self._control.ve, self._control.vn) if self._has_course else None

    @property
    def _has_course(self) -> bool:
        control = self._control
        vn, ve = control.vn, control.ve
        least = _TURNING_SHARE * control.speed_max
        return vn * vn + ve * ve > least * least

    def _along_target(self) -> float:
        """Take the target's course, or without one keep the heading; returns the yaw rate."""
        if not self._has_course:
            self.target_rad = self._airframe.heading.target
            return 0.0
        control = self._control
        vn, ve = control.vn, control.ve
        self.target_rad = atan2(ve, vn)
        return (control.accel_e * vn - control.accel_n * ve) / (vn * vn + ve * ve)
