"""The flight model under the autopilot's orders: modes and targets become the model's commands.

The model lives in metres around home. Home moves when the vehicle is armed somewhere else; the
local frame of the messages stays where the EKF set its origin, so positions are given in that one
and ``_shift_m`` lies between the two.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import pi, radians

from flight_replay.flight_modes import CopterMode
from flight_replay.simulator.autopilot.location import Metres, Start
from flight_replay.simulator.autopilot.model_parameters import limits_of, wind_m_s
from flight_replay.simulator.flight.auto import MissionRun
from flight_replay.simulator.flight.copter import STEP_S, Copter
from flight_replay.simulator.flight.takeoff import TakeOff
from flight_replay.simulator.mission.local_items import LocalItem

__all__ = ["STEP_S", "ModelFlight"]


class ModelFlight:
    """The simulated copter as the autopilot sees it."""

    def __init__(self, parameters: Mapping[str, float], start: Start, *, takeoff_climbs: bool = True) -> None:
        """On the ground.

        Args:
            parameters: the autopilot's table, read at every use.
            start: where the copter is.
            takeoff_climbs: whether a take-off leaves the ground.
        """
        self._parameters, self._start, self._takeoff_climbs = parameters, start, takeoff_climbs
        self._shift_m: Metres = (0.0, 0.0, 0.0)
        self._new_limits = False
        self._copter = self._made((0.0, 0.0, 0.0), radians(start.heading_deg))
        self._attitude_before = self._copter.attitude_rad
        self._goal_m: Metres | None = None
        self._is_stuck = False

    def _made(self, position_m: Metres, yaw_rad: float, velocity_m_s: Metres = (0.0, 0.0, 0.0)) -> Copter:
        return Copter(
            limits_of(self._parameters),
            position_m=position_m,
            yaw_rad=yaw_rad,
            velocity_m_s=velocity_m_s,
            wind_m_s=wind_m_s(self._parameters, position_m[2] + self._shift_m[2]),
            home_amsl_m=self._start.alt_amsl_m,
        )

    # state

    @property
    def position_m(self) -> Metres:
        """North, east and up of the EKF's origin."""
        return self._from_home(self._copter.position_m)

    def _from_home(self, position_m: Metres) -> Metres:
        shift = self._shift_m
        return position_m[0] + shift[0], position_m[1] + shift[1], position_m[2] + shift[2]

    def _to_home(self, position_m: Metres) -> Metres:
        shift = self._shift_m
        return position_m[0] - shift[0], position_m[1] - shift[1], position_m[2] - shift[2]

    @property
    def velocity_m_s(self) -> Metres:
        """North, east and up."""
        return self._copter.velocity_m_s

    @property
    def attitude_rad(self) -> Metres:
        """Roll, pitch and yaw."""
        return self._copter.attitude_rad

    @property
    def rates_rad_s(self) -> Metres:
        """Rates of roll, pitch and yaw over the last step."""
        now, before = self._copter.attitude_rad, self._attitude_before
        roll, pitch, yaw = (((a - b + pi) % (2 * pi) - pi) / STEP_S for a, b in zip(now, before, strict=True))
        return roll, pitch, yaw

    @property
    def throttle(self) -> float:
        """0 to 1."""
        return self._copter.throttle

    @property
    def landed(self) -> bool:
        """Whether it stands on the ground."""
        return self._copter.landed

    @property
    def motors(self) -> bool:
        """Whether the motors turn; they stop by themselves after a landing."""
        return self._copter.motors

    @property
    def landing(self) -> bool:
        """Whether it descends to land."""
        return self._copter.landing

    @property
    def taking_off(self) -> bool:
        """Whether a take-off was ordered and is not done."""
        phase = self._copter.phase
        return self._is_stuck or (isinstance(phase, TakeOff) and not phase.done)

    @property
    def target_m(self) -> Metres:
        """Where the vehicle is heading, around the EKF's origin."""
        run = self._copter.mission
        goal_m = run.destination_m if run is not None else self._goal_m
        return self._from_home(goal_m if goal_m is not None else self._copter.target_m)

    @property
    def height_error_m(self) -> float:
        """How far below its momentary target the vehicle is."""
        return self._copter.target_m[2] - self._copter.position_m[2] if self._copter.motors else 0.0

    # time

    def step(self) -> None:
        """Move STEP_S on."""
        if self._new_limits:
            self._new_limits = False
            self._copter.change_limits(limits_of(self._parameters))
        self._copter.change_wind(wind_m_s(self._parameters, self.position_m[2]))
        self._attitude_before = self._copter.attitude_rad
        self._copter.step()

    def parameters_changed(self) -> None:
        """Fly by the parameters as they are from the next step on."""
        self._new_limits = True

    # orders

    def arm(self) -> None:
        """The motors idle; home is here from now on."""
        self._shift_m = self._from_home(self._copter.position_m)
        self._copter = self._made((0.0, 0.0, 0.0), self._copter.attitude_rad[2])
        self._copter.arm()

    def disarm(self) -> None:
        """The motors stop; in the air that is a fall, of which only the end is modelled."""
        if not self._copter.landed:
            north_m, east_m, _ = self._copter.position_m
            self._copter = self._made((north_m, east_m, 0.0), self._copter.attitude_rad[2])
        self._copter.disarm()
        self._is_stuck = False

    def move_home(self, position_m: Metres, mode: CopterMode) -> None:
        """Home is another place, level with the ground; what the mode does begins anew."""
        now_m, yaw_rad = self.position_m, self._copter.attitude_rad[2]
        velocity_m_s, motors = self._copter.velocity_m_s, self._copter.motors
        self._shift_m = (position_m[0], position_m[1], self._shift_m[2])
        self._copter = self._made(self._to_home(now_m), yaw_rad, velocity_m_s)
        if motors and self._copter.landed:
            self._copter.arm()
        elif motors:
            self.enter_mode(mode)

    def enter_mode(self, mode: CopterMode) -> None:
        """Begin what a mode does; nothing leaves the ground by it."""
        self._goal_m = None
        if not self._copter.motors or self._copter.landed:
            return
        if mode == CopterMode.RTL:
            self._goal_m = (0.0, 0.0, self._copter.position_m[2])
            self._copter.return_home()
        elif mode == CopterMode.LAND:
            self._copter.land()
        else:
            self._copter.hold()

    def takeoff(self, up_m: float) -> None:
        """Climb straight up, to a height above home."""
        north_m, east_m, _ = self._copter.position_m
        self._goal_m = (north_m, east_m, up_m)
        if self._takeoff_climbs:
            self._copter.takeoff(up_m)
        else:
            self._is_stuck = True

    def goto(self, position_m: Metres) -> None:
        """Fly to a place given around the EKF's origin."""
        self._goal_m = self._to_home(position_m)
        self._copter.goto(self._goal_m)

    def drift(self, velocity_m_s: Metres) -> None:
        """Fly at a velocity, north, east and up, until told otherwise."""
        self._goal_m = None
        self._copter.drift(velocity_m_s)

    def look(self, angle_rad: float, rate_rad_s: float, direction: float, *, relative: bool) -> None:
        """Turn to a heading, or by an angle."""
        self._copter.look(angle_rad, rate_rad_s, direction, relative=relative)

    def stop(self) -> None:
        """Hold here."""
        self._goal_m = None
        self._copter.hold()

    def change_speed(self, kind: int, speed_m_s: float) -> bool:
        """Another speed until the mode changes: kind 0 and 1 level, 2 climb, 3 descent."""
        return self._copter.change_speed(kind, speed_m_s)

    def fly_mission(self, items: Sequence[LocalItem], seq: int) -> MissionRun:
        """Run the items from a sequence number on."""
        return self._copter.start_auto(items, seq)
