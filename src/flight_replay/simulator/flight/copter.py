"""A multicopter with ArduCopter's navigation: commands in, motion out, in constant steps.

No clock, no link and no randomness: the same commands at the same steps give the same flight.
Metres north, east and up of home.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import nan

from flight_replay.mission.items import FIRST_SEQ
from flight_replay.simulator.dynamics.aerodynamics import Air
from flight_replay.simulator.dynamics.airframe import Airframe
from flight_replay.simulator.dynamics.auto_yaw import AutoYaw
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.position_control import PositionControl
from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.auto import MissionRun
from flight_replay.simulator.flight.flight_control import FlightControl
from flight_replay.simulator.flight.guided import (
    GuidedSubMode,
    GuidedTarget,
    GuidedVelocity,
    submode_for,
)
from flight_replay.simulator.flight.landing import Landing
from flight_replay.simulator.flight.rtl import ReturnToLaunch
from flight_replay.simulator.flight.submode import Hold, OnGround, SubMode
from flight_replay.simulator.flight.takeoff import TakeOff
from flight_replay.simulator.mission.local_items import LocalItem
from flight_replay.simulator.navigation.waypoint_navigation import WaypointNavigation

STEP_S = 0.02


class Copter(SnapshotPart):
    """The vehicle: give a command, then ``step``; every step lasts ``step_s``."""

    def __init__(  # noqa: PLR0913
        self,
        limits: Limits,
        *,
        position_m: Vector = (0.0, 0.0, 0.0),
        velocity_m_s: Vector = (0.0, 0.0, 0.0),
        yaw_rad: float = 0.0,
        wind_m_s: Vector = (0.0, 0.0, 0.0),
        home_amsl_m: float = 0.0,
        step_s: float = STEP_S,
    ) -> None:
        """On the ground at home, or flying at a position above it.

        Args:
            limits: what the vehicle's parameters allow.
            position_m: at the start; above the ground the vehicle flies already.
            velocity_m_s: at the start, north, east, up.
            yaw_rad: heading at the start.
            wind_m_s: velocity of the air, north, east, up.
            home_amsl_m: home above mean sea level, for the density of the air.
            step_s: duration of a step.
        """
        self.limits = limits
        self.step_s = step_s
        self.steps = 0
        self._airframe = airframe = Airframe(limits, position_m, yaw_rad, Air(wind_m_s, home_amsl_m), step_s)
        airframe.vn, airframe.ve, airframe.vu = velocity_m_s
        if any(wind_m_s) and not airframe.on_ground:
            airframe.lean_into_wind()
        control = PositionControl(limits, airframe)
        self._flight = FlightControl(
            limits,
            airframe,
            control,
            WaypointNavigation(limits, airframe, control),
            AutoYaw(limits, airframe, control),
        )
        self.motors = not airframe.on_ground
        self._submode: SubMode = OnGround() if airframe.on_ground else Hold(self._flight)

    # state

    @property
    def time_s(self) -> float:
        """Seconds since the beginning."""
        return self.steps * self.step_s

    @property
    def position_m(self) -> Vector:
        """North, east, up of home."""
        return self._airframe.n, self._airframe.e, self._airframe.u

    @property
    def velocity_m_s(self) -> Vector:
        """North, east, up."""
        return self._airframe.vn, self._airframe.ve, self._airframe.vu

    @property
    def motion(self) -> tuple[float, float, float, float, float, float, float]:
        """Time, position and velocity at once."""
        airframe = self._airframe
        return (
            self.steps * self.step_s,
            airframe.n,
            airframe.e,
            airframe.u,
            airframe.vn,
            airframe.ve,
            airframe.vu,
        )

    @property
    def attitude_rad(self) -> tuple[float, float, float]:
        """Roll, pitch, yaw."""
        return self._airframe.attitude_rad

    @property
    def yaw_rad(self) -> float:
        """Where the nose points, clockwise from north."""
        return self._airframe.yaw

    @property
    def course_rad(self) -> float:
        """Where the nose turns to by itself in AUTO; not a number where it does not turn."""
        course = self._flight.auto_yaw.course_rad
        return nan if course is None else course

    @property
    def throttle(self) -> float:
        """Throttle, 0 to 1."""
        return self._airframe.throttle

    @property
    def landed(self) -> bool:
        """Whether the vehicle is on the ground."""
        return self._airframe.on_ground

    @property
    def landing(self) -> bool:
        """Whether the vehicle descends to land."""
        submode = self._submode
        return isinstance(submode, Landing) or (
            isinstance(submode, ReturnToLaunch | MissionRun) and submode.landing
        )

    @property
    def target_m(self) -> Vector:
        """Where the position controller's target is."""
        control = self._flight.control
        return control.n, control.e, control.u

    @property
    def submode(self) -> SubMode:
        """The present submode."""
        return self._submode

    @property
    def goal(self) -> GuidedTarget | None:
        """What GUIDED follows, if that is what the vehicle does."""
        return self._submode.goal if isinstance(self._submode, GuidedSubMode) else None

    @property
    def has_error(self) -> bool:
        """Whether ArduPilot has reported an internal error on a leg, and arms only after a reboot."""
        return self._flight.navigation.has_error

    @property
    def mission(self) -> MissionRun | None:
        """The mission that is running, if the vehicle is in AUTO."""
        return self._submode if isinstance(self._submode, MissionRun) else None

    # parameters

    def set_home(self, position_m: Vector) -> None:
        """Make a position home, where the next RTL lands."""
        self._flight.home = position_m

    def change_limits(self, limits: Limits) -> None:
        """Use other limits from now on; changed speeds apply to a mission that is flown."""
        before, self.limits = self.limits, limits
        self._flight.use_limits(limits)
        for kind, old, new in (
            (1, before.wp_speed_m_s, limits.wp_speed_m_s),
            (2, before.wp_speed_up_m_s, limits.wp_speed_up_m_s),
            (3, before.wp_speed_down_m_s, limits.wp_speed_down_m_s),
        ):
            if old != new and self.mission is not None:
                self.change_speed(kind, new)

    def change_wind(self, wind_m_s: Vector) -> None:
        """Use another velocity of the air, north, east, up."""
        self._airframe.use_wind(wind_m_s)

    def change_speed(self, kind: int, speed_m_s: float) -> bool:
        """Change the speed of the present submode, kinds as in DO_CHANGE_SPEED; False if it has none.

        In GUIDED a climb speed resets the descent speed, and the other way round (mode_guided.cpp).
        """
        flight, limits = self._flight, self.limits
        if isinstance(self._submode, MissionRun | ReturnToLaunch):
            change = {2: flight.navigation.set_speed_up, 3: flight.navigation.set_speed_down}
            change.get(kind, flight.navigation.set_speed)(speed_m_s)
            return True
        if not isinstance(self._submode, TakeOff | GuidedSubMode | Hold):
            return False
        level, up, down = flight.control.speed_max, flight.control.speed_up, flight.control.speed_down
        speeds = {
            2: (level, speed_m_s, limits.wp_speed_down_m_s),
            3: (level, limits.wp_speed_up_m_s, speed_m_s),
        }
        flight.control.set_speeds(*speeds.get(kind, (speed_m_s, up, down)))
        flight.control.limit_correction()
        return True

    # commands

    def arm(self) -> None:
        """Start the motors at idle."""
        self.motors = True
        self._flight.arming_wait_s = self.limits.arming_delay_s
        self._flight.auto_yaw.armed_yaw_rad = self._airframe.yaw

    def disarm(self) -> None:
        """Stop the motors."""
        self.motors = False
        self._submode = OnGround()

    def takeoff(self, altitude_m: float) -> None:
        """Climb straight up, as NAV_TAKEOFF in GUIDED does; arms first if necessary."""
        if not self.motors:
            self.arm()
        limits = self.limits
        self._flight.control.set_speeds(limits.wp_speed_m_s, limits.wp_speed_up_m_s, limits.wp_speed_down_m_s)
        self._flight.control.limit_correction()
        self._submode = TakeOff(self._flight, altitude_m)

    def follow(self, target: GuidedTarget, late_s: float = 0.0) -> None:
        """Follow a target as GUIDED does; one that GUIDED cannot fly stops the vehicle.

        Args:
            target: what to follow.
            late_s: how long ago it came, less than zero if it is about to; a moving target is moved by that.
        """
        kind = submode_for(target)
        if kind is None:
            self.stop()
            return
        submode = self._submode
        if type(submode) is not kind or not isinstance(submode, GuidedSubMode):
            self._submode = submode = kind(self._flight, keeps_heading=target.keeps_heading)
        submode.accept(target, late_s)

    def stop(self) -> None:
        """Come to rest, as GUIDED does when it is entered."""
        self._submode = GuidedVelocity(self._flight)

    def set_yaw(
        self, angle_rad: float, rate_rad_s: float = 0.0, direction: float = 0.0, *, relative: bool = False
    ) -> None:
        """Turn to a heading, or by an angle, until another command turns the vehicle."""
        self._flight.auto_yaw.set_fixed_yaw(angle_rad, rate_rad_s, direction, relative=relative)

    def face(self, north_east_m: tuple[float, float] | None) -> None:
        """Face a position from now on; without one look along the path again."""
        if north_east_m is None:
            self._flight.auto_yaw.set_default_mode()
        else:
            self._flight.auto_yaw.face(north_east_m)

    def hold(self) -> None:
        """Stop, and hold position."""
        self._submode = Hold(self._flight)

    def start_auto(self, items: Sequence[LocalItem], start_seq: int = FIRST_SEQ) -> MissionRun:
        """Fly a mission from an item on; returns its progress."""
        self._submode = run = MissionRun(self._flight, items, start_seq)
        return run

    def return_home(self) -> None:
        """Climb, return, loiter and land, as RTL does."""
        self._submode = ReturnToLaunch(self._flight)

    def land(self) -> None:
        """Land here."""
        self._submode = Landing(self._flight)

    def pause_landing(self) -> None:
        """Wait before a landing that was just begun."""
        if isinstance(self._submode, Landing):
            self._submode.pause()

    def step(self) -> None:
        """Move ``step_s`` on."""
        self._submode.step()
        self.steps += 1
        if self._flight.arming_wait_s > 0:
            self._flight.arming_wait_s = max(0.0, self._flight.arming_wait_s - self.step_s)
        if self._submode.done and isinstance(self._submode, Landing | ReturnToLaunch | MissionRun):
            self.disarm()
