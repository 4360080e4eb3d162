"""The copter of the flight model as the autopilot commands it.

Modes and targets become commands to ``Copter``, which counts metres from where the vehicle was armed.
The EKF's origin stays, and positions here are metres from there: ``armed_m``, where it was armed, and
``_home_m``, which stations may move.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import radians

from flight_replay.flight_modes import CopterMode
from flight_replay.simulator.autopilot.flight_parameters import limits_of, wind_m_s
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.shaping import wrap_pi
from flight_replay.simulator.dynamics.vector import Vector, minus
from flight_replay.simulator.flight.auto import MissionRun
from flight_replay.simulator.flight.copter import STEP_S, Copter
from flight_replay.simulator.flight.guided import GuidedTarget
from flight_replay.simulator.flight.rtl import ReturnToLaunch
from flight_replay.simulator.flight.takeoff import TakeOff
from flight_replay.simulator.mission.local_items import LocalItem


class CommandedCopter:
    """The simulated copter as the autopilot sees it."""

    def __init__(
        self,
        parameters: Mapping[str, float],
        start: Start,
        *,
        takeoff_climbs: bool,
        checks_speed: bool,
    ) -> None:
        """On the ground.

        Args:
            parameters: the autopilot's table, read at every use.
            start: where the copter is.
            takeoff_climbs: whether a take-off leaves the ground.
            checks_speed: whether the first mission goes on at WPNAV_SPEED, whatever speed its first items
                ask for, if that is not the compiled default: AC_WPNav::update_wpnav compares the two the
                first time that it runs, and takes the parameter for changed in flight.
        """
        self._parameters, self._start, self._takeoff_climbs = parameters, start, takeoff_climbs
        self.armed_m: Vector = (0.0, 0.0, 0.0)
        self._home_m = self.armed_m
        self._limits_changed = False
        self._speed_unchecked = checks_speed
        self._copter = self._new_copter((0.0, 0.0, 0.0), radians(start.heading_deg))
        self._last_attitude = self._copter.attitude_rad
        self._destination_m: Vector | None = None
        self._takeoff_stuck = False

    def _new_copter(self, position_m: Vector, yaw_rad: float) -> Copter:
        """A copter that stands there, with the parameters as they are now."""
        copter = Copter(
            limits_of(self._parameters),
            position_m=position_m,
            yaw_rad=yaw_rad,
            wind_m_s=wind_m_s(self._parameters, position_m[2] + self.armed_m[2]),
            home_amsl_m=self._start.alt_amsl_m,
        )
        copter.set_home(self._inside(self._home_m))
        return copter

    # state

    @property
    def position_m(self) -> Vector:
        """North, east and up of the EKF's origin."""
        return self._outside(self._copter.position_m)

    def _outside(self, position_m: Vector) -> Vector:
        """A position of the flight model, in metres around the EKF's origin."""
        n, e, u = self.armed_m
        return position_m[0] + n, position_m[1] + e, position_m[2] + u

    def _inside(self, position_m: Vector) -> Vector:
        return minus(position_m, self.armed_m)

    @property
    def velocity_m_s(self) -> Vector:
        """North, east and up."""
        return self._copter.velocity_m_s

    @property
    def attitude_rad(self) -> Vector:
        """Roll, pitch and yaw."""
        return self._copter.attitude_rad

    @property
    def rates_rad_s(self) -> Vector:
        """Rates of roll, pitch and yaw over the last step."""
        now, before = self._copter.attitude_rad, self._last_attitude
        roll, pitch, yaw = (wrap_pi(a - b) / STEP_S for a, b in zip(now, before, strict=True))
        return roll, pitch, yaw

    @property
    def throttle(self) -> float:
        """0 to 1."""
        return self._copter.throttle

    @property
    def landed(self) -> bool:
        """Whether the copter is on the ground."""
        return self._copter.landed

    @property
    def motors(self) -> bool:
        """Whether the motors turn; they stop by themselves after a landing."""
        return self._copter.motors

    @property
    def landing(self) -> bool:
        """Whether the copter descends to land."""
        return self._copter.landing

    @property
    def taking_off(self) -> bool:
        """Whether a take-off was commanded and is not done."""
        submode = self._copter.submode
        return self._takeoff_stuck or (isinstance(submode, TakeOff) and not submode.done)

    @property
    def target_m(self) -> Vector:
        """Where the vehicle flies to, around the EKF's origin."""
        run = self._copter.mission
        destination_m = run.destination_m if run is not None else self._destination_m
        return self._outside(destination_m if destination_m is not None else self._copter.target_m)

    @property
    def goal(self) -> GuidedTarget | None:
        """What GUIDED follows, around the EKF's origin."""
        goal = self._copter.goal
        if goal is None or goal.position_m is None:
            return goal
        return replace(goal, position_m=self._outside(goal.position_m))

    @property
    def height_error_m(self) -> float:
        """How far the vehicle is below its present target."""
        return self._copter.target_m[2] - self._copter.position_m[2] if self._copter.motors else 0.0

    # time

    def step(self) -> None:
        """Move STEP_S on."""
        if self._limits_changed:
            self._limits_changed = False
            self._copter.change_limits(limits_of(self._parameters))
        self._copter.change_wind(wind_m_s(self._parameters, self.position_m[2]))
        self._last_attitude = self._copter.attitude_rad
        self._copter.step()
        if self._speed_unchecked and isinstance(self._copter.submode, MissionRun | ReturnToLaunch):
            self._check_speed()

    def _check_speed(self) -> None:
        self._speed_unchecked, speed_m_s = False, self._copter.limits.wp_speed_m_s
        if speed_m_s != Limits().wp_speed_m_s:
            self._copter.change_speed(1, speed_m_s)

    def parameters_changed(self) -> None:
        """Read the parameters again at the next step."""
        self._limits_changed = True

    # commands

    def arm(self) -> None:
        """Start the motors at idle."""
        self.armed_m = self._outside(self._copter.position_m)
        self._copter = self._new_copter((0.0, 0.0, 0.0), self._copter.attitude_rad[2])
        self._copter.arm()

    def disarm(self) -> None:
        """Stop the motors; in the air the copter falls, of which only the end is modelled."""
        if not self._copter.landed:
            north_m, east_m, _ = self._copter.position_m
            self._copter = self._new_copter((north_m, east_m, 0.0), self._copter.attitude_rad[2])
        self._copter.disarm()
        self._takeoff_stuck = False

    def set_home(self, position_m: Vector) -> None:
        """Make a position home; a return that has begun goes on to where home was."""
        self._home_m = position_m
        self._copter.set_home(self._inside(position_m))

    def enter_mode(self, mode: CopterMode) -> None:
        """Begin what a mode does; the copter does not leave the ground by it."""
        self._destination_m = None
        if not self._copter.motors or self._copter.landed:
            return
        if mode == CopterMode.RTL:
            n, e, _ = self._inside(self._home_m)
            self._destination_m = (n, e, self._copter.position_m[2])
            self._copter.return_home()
        elif mode == CopterMode.LAND:
            self._copter.land()
        elif mode == CopterMode.GUIDED:
            self._copter.stop()
        else:
            self._copter.hold()

    def takeoff(self, up_m: float) -> None:
        """Climb straight up, to a height above home."""
        north_m, east_m, _ = self._copter.position_m
        up_m += self._inside(self._home_m)[2]
        self._destination_m = (north_m, east_m, up_m)
        if self._takeoff_climbs:
            self._copter.takeoff(up_m)
        else:
            self._takeoff_stuck = True

    def follow(self, target: GuidedTarget) -> None:
        """Follow a target as GUIDED does; its position is around the EKF's origin."""
        self._destination_m = None
        if target.position_m is not None:
            target = replace(target, position_m=self._inside(target.position_m))
            self._destination_m = target.position_m if target.velocity_m_s is None else None
        self._copter.follow(target)

    def set_yaw(self, angle_rad: float, rate_rad_s: float, direction: float, *, relative: bool) -> None:
        """Turn to a heading, or by an angle (CONDITION_YAW)."""
        self._copter.set_yaw(angle_rad, rate_rad_s, direction, relative=relative)

    def pause_landing(self) -> None:
        """Wait before a landing that was just begun."""
        self._copter.pause_landing()

    def face(self, position_m: Vector | None) -> None:
        """Face a position around the EKF's origin; None ends that."""
        self._copter.face(None if position_m is None else self._inside(position_m)[:2])

    def stop(self) -> None:
        """Come to rest, and stay."""
        self._destination_m = None
        self._copter.stop()

    def change_speed(self, kind: int, speed_m_s: float) -> None:
        """Change the speed until the mode changes: kind 0 and 1 horizontal, 2 climb, 3 descent."""
        self._copter.change_speed(kind, speed_m_s)

    def fly_mission(self, items: Sequence[LocalItem], seq: int) -> MissionRun:
        """Fly the mission from a sequence number on."""
        return self._copter.start_auto(items, seq)
