"""Which way the copter looks (ArduCopter/autoyaw.cpp and AC_PosControl::calculate_yaw_and_rate_yaw)."""

from __future__ import annotations

from enum import Enum
from math import atan2, hypot, pi, radians

from flight_replay.simulator.dynamics.airframe import Airframe
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.position_control import PositionControl
from flight_replay.simulator.dynamics.shaping import clamp

# WP_YAW_BEHAVIOR.
_NEVER, _NEXT_WAYPOINT, _NEXT_WAYPOINT_EXCEPT_RTL, _AHEAD = 0, 1, 2, 3
# AC_PosControl.cpp turns the target only above this share of the highest speed.
_TURNING_SHARE = 0.05
# autoyaw.cpp: YAW_LOOK_AHEAD_MIN_SPEED, 1 m/s.
_LOOK_AHEAD_SPEED_M_S = 1.0
_CLOSE_ENOUGH = radians(2.0)


class Look(Enum):
    """Where to look."""

    HOLD = "the same way"
    NEXT_WAYPOINT = "along the target's path"
    AHEAD = "along the flown path"
    FIXED = "at a given heading"


class Heading:
    """The heading wished for; ``update`` turns the airframe one step towards it."""

    def __init__(self, limits: Limits, body: Airframe, control: PositionControl) -> None:
        self._limits, self._body, self._control = limits, body, control
        self.look = Look.HOLD
        self.wanted_rad = self.armed_rad = body.yaw
        self._left_rad = 0.0
        self._turn_rate = 0.0

    def use_limits(self, limits: Limits) -> None:
        """Go by other parameters from now on."""
        self._limits = limits

    def hold(self) -> None:
        """Keep the present heading."""
        self.look = Look.HOLD
        self.wanted_rad = self._body.yaw

    def use_default(self, *, returning: bool = False) -> None:
        """Look where WP_YAW_BEHAVIOR says (AutoYaw::default_mode)."""
        behavior = self._limits.wp_yaw_behavior
        if behavior == _NEVER or (behavior == _NEXT_WAYPOINT_EXCEPT_RTL and returning):
            self.look = Look.HOLD
        elif behavior == _AHEAD:
            self.look = Look.AHEAD
        else:
            self.look = Look.NEXT_WAYPOINT

    def fix(
        self, angle_rad: float, rate_rad_s: float = 0.0, direction: float = 0.0, *, relative: bool = False
    ) -> None:
        """Turn to an angle, or by one (AutoYaw::set_fixed_yaw)."""
        if relative:
            self._left_rad = angle_rad * (1.0 if direction >= 0 else -1.0)
        else:
            self._left_rad = (angle_rad - self.wanted_rad + pi) % (2 * pi) - pi
            if direction * self._left_rad < 0:
                self._left_rad += 2 * pi if direction > 0 else -2 * pi
        slew = self._limits.yaw_slew_rad_s
        self._turn_rate = min(slew, rate_rad_s) if rate_rad_s > 0 else slew
        self.look = Look.FIXED

    def face(self, place_m: tuple[float, float]) -> None:
        """Look at a place, north and east of home, and turn one step (ROI, circles)."""
        self.look = Look.HOLD
        body = self._body
        self.wanted_rad = atan2(place_m[1] - body.e, place_m[0] - body.n)
        self.update()

    def face_as_armed(self) -> None:
        """Look where the vehicle looked when it was armed (RESETTOARMEDYAW)."""
        self.look = Look.HOLD
        self._left_rad = 0.0
        self.wanted_rad = self.armed_rad

    @property
    def holds_when_returning(self) -> bool:
        """Whether RTL leaves the heading alone (AutoYaw::default_mode)."""
        return self._limits.wp_yaw_behavior in (_NEVER, _NEXT_WAYPOINT_EXCEPT_RTL)

    def go_on(self) -> None:
        """Go on turning to a fixed heading, whoever has looked elsewhere since (ModeAuto::verify_yaw)."""
        self.look = Look.FIXED

    @property
    def reached(self) -> bool:
        """Whether a fixed heading is looked at, within 2 degrees (AutoYaw::reached_fixed_yaw_target)."""
        error = (self.wanted_rad - self._body.yaw + pi) % (2 * pi) - pi
        return self._left_rad == 0 and abs(error) <= _CLOSE_ENOUGH

    def update(self) -> None:
        """Turn the airframe one step."""
        rate = 0.0
        control, body = self._control, self._body
        if self.look is Look.NEXT_WAYPOINT:
            rate = self._along_target()
        elif self.look is Look.FIXED:
            step = self._turn_rate * control.dt
            step = clamp(self._left_rad, -step, step)
            self._left_rad -= step
            self.wanted_rad += step
        elif self.look is Look.AHEAD and hypot(body.vn, body.ve) > _LOOK_AHEAD_SPEED_M_S:
            self.wanted_rad = atan2(body.ve, body.vn)
        body.turn_towards(self.wanted_rad, rate)

    def _along_target(self) -> float:
        """Look along the target's velocity; returns its turn rate."""
        control = self._control
        vn, ve = control.vn, control.ve
        square = vn * vn + ve * ve
        if square <= (_TURNING_SHARE * control.speed_max) ** 2:
            return 0.0
        self.wanted_rad = atan2(ve, vn)
        return (control.accel_e * vn - control.accel_n * ve) / square
