"""The autopilot: modes, arming, home and status texts; no I/O, and no clock but the vehicle's.

Time passes only in ``step``; what happens on board is reported to ``observers``. The behaviour is
ArduCopter 4.6's; the flight itself is ``commanded_copter``'s.
"""

from __future__ import annotations

import math

from flight_replay.events import Severity
from flight_replay.flight_modes import CopterMode
from flight_replay.simulator.autopilot.arming import Arming
from flight_replay.simulator.autopilot.battery import Battery
from flight_replay.simulator.autopilot.commanded_copter import CommandedCopter
from flight_replay.simulator.autopilot.context import AutopilotObserver
from flight_replay.simulator.autopilot.ekf_frame import EkfFrame
from flight_replay.simulator.autopilot.failsafes import Failsafes
from flight_replay.simulator.autopilot.fault_script import FaultScript
from flight_replay.simulator.autopilot.faults import Faults
from flight_replay.simulator.autopilot.location import HomeLocation, Location, Start
from flight_replay.simulator.autopilot.mission_control import MissionControl
from flight_replay.simulator.autopilot.mode_switch import ModeSwitch
from flight_replay.simulator.autopilot.parameter_table import Parameter, Parameters
from flight_replay.simulator.autopilot.prearm import Prearm
from flight_replay.simulator.autopilot.sensors import Sensors
from flight_replay.simulator.autopilot.target_fence import is_within_fence
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.copter import STEP_S
from flight_replay.simulator.mission.store import MissionStore

_HAS_TARGET = frozenset({CopterMode.AUTO, CopterMode.GUIDED, CopterMode.RTL})


class Autopilot:
    """One simulated ArduCopter; ``unix_s`` is the wall-clock time at boot, for SYSTEM_TIME only."""

    def __init__(
        self,
        start: Start,
        *,
        parameters: Parameters | None = None,
        faults: Faults | None = None,
        unix_s: float = 0.0,
    ) -> None:
        self.faults = faults or Faults()
        self.parameters = parameters or self.faults.firmware.parameter_table()
        self.observers: list[AutopilotObserver] = []
        self._unix_s = unix_s
        for name, value in (
            ("SIM_OPOS_LAT", start.lat_deg),
            ("SIM_OPOS_LNG", start.lon_deg),
            ("SIM_OPOS_ALT", start.alt_amsl_m),
            ("SIM_OPOS_HDG", start.heading_deg),
        ):
            self.parameters.assign(name, value)
        self.parameters.on_change.append(self._parameter_changed)
        self.store = MissionStore(lambda: self.ekf_frame.home_item, self._mission_length_changed)
        self._script = FaultScript(self)
        self.boot(start)

    def boot(self, at: Start) -> None:
        """Boot at a location: everything is forgotten but the parameters and the mission."""
        self._steps = 0
        self.home_is_locked = False
        self.ekf_frame = EkfFrame(at)
        self.sensors = Sensors()
        self.battery = Battery(self.parameters)
        self.flight = CommandedCopter(
            self.parameters,
            at,
            takeoff_climbs=self.faults.takeoff_climbs,
            checks_speed=self.faults.firmware.checks_speed,
        )
        self.mission = MissionControl(self)
        self.modes = ModeSwitch(self, self.mission)
        self.failsafes = Failsafes(self)
        self.prearm = Prearm(self, self.failsafes)
        self.arming = Arming(self, self.prearm, self.mission)
        self.trigger("boot")

    def reboot(self) -> None:
        """Boot again where the vehicle is; in the air it falls."""
        location, yaw_rad = self.location, self.flight.attitude_rad[2]
        ground_m = self.start.alt_amsl_m
        self.boot(Start(location.lat_e7 / 1e7, location.lon_e7 / 1e7, ground_m, math.degrees(yaw_rad)))
        for observer in self.observers:
            observer.rebooted()

    # time

    def step(self) -> None:
        """Let STEP_S seconds of the vehicle's time pass."""
        self._steps += 1
        for text in self.sensors.advance(self.time_s):
            self.say(Severity.INFO, text)
        self.sensors.gps_disabled = bool(self.parameters["SIM_GPS_DISABLE"])
        if self.home is None and self.sensors.origin_set:
            self.set_home((0.0, 0.0, 0.0))
            self.say(Severity.INFO, f"Field Elevation Set: {self.start.alt_amsl_m:.0f}m")
        self.flight.step()
        self.mission.update()
        self.arming.update()
        self.battery.draw(
            STEP_S, armed=self.armed, landed=self.flight.landed, climb_m_s=self.flight.velocity_m_s[2]
        )
        self.failsafes.update()
        self.prearm.update()
        self._script.update()

    @property
    def time_s(self) -> float:
        """Seconds since boot, by the vehicle's clock."""
        return self._steps * STEP_S

    @property
    def time_boot_ms(self) -> int:
        """The same in whole milliseconds, as messages have it."""
        return int(self.time_s * 1000)

    @property
    def unix_us(self) -> int:
        """The time that GPS gives, µs since 1970."""
        return int((self._unix_s + self.time_s) * 1e6)

    # reports

    def say(self, severity: Severity, text: str) -> None:
        """Send a status text to every station."""
        for observer in self.observers:
            observer.status_text(severity, text)

    def mode_entered(self) -> None:
        """Report that the mode has changed."""
        for observer in self.observers:
            observer.mode_changed()
        self.trigger(self.mode.name)

    def item_reached(self, seq: int) -> None:
        """Report a mission item as reached."""
        for observer in self.observers:
            observer.item_reached(seq)

    def trigger(self, name: str) -> None:
        """Start what the fault script has for this trigger."""
        self._script.trigger(name)

    def _parameter_changed(self, parameter: Parameter) -> None:
        self.flight.parameters_changed()

    def _mission_length_changed(self, count: int) -> None:
        self.parameters.assign("MIS_TOTAL", count)

    # positions

    @property
    def start(self) -> Start:
        """Where the vehicle was booted, which is the EKF's origin."""
        return self.ekf_frame.start

    @property
    def home(self) -> HomeLocation | None:
        """Home, once the EKF has an origin."""
        return self.ekf_frame.home

    @property
    def location(self) -> Location:
        """Where the copter is."""
        return self.start.location_of(self.flight.position_m)

    @property
    def target_m(self) -> Vector | None:
        """Where the vehicle flies to, around the EKF's origin; None in modes without a target."""
        return self.flight.target_m if self.armed and self.mode in _HAS_TARGET else None

    @property
    def above_home_m(self) -> float:
        """Height above home."""
        return self.flight.position_m[2] - (self.home.position_m[2] if self.home else 0.0)

    def allows_target(self, position_m: Vector) -> bool:
        """Whether the fence, around home, lets the vehicle fly to a position."""
        home_m = self.home.position_m if self.home else (0.0, 0.0, 0.0)
        return is_within_fence(self.parameters, home_m, position_m)

    def move_home(self, position_m: Vector) -> None:
        """Move home for a station, to stay there when the vehicle is armed elsewhere."""
        self.home_is_locked = True
        self.set_home(position_m)

    def set_home(self, position_m: Vector) -> None:
        """Make a position home, and report it."""
        self.ekf_frame.set_home(position_m)
        self.flight.set_home(position_m)
        self.mission.home_moved()
        for observer in self.observers:
            observer.home_changed()

    # modes and motors

    @property
    def armed(self) -> bool:
        """Whether the motors are armed."""
        return self.arming.armed

    @property
    def mode(self) -> CopterMode:
        """The flight mode."""
        return self.modes.mode

    def request_mode(self, number: int) -> bool:
        """Enter a mode that a station asks for by its number; whether it was entered."""
        return self.modes.request(number)

    def set_mode(self, mode: CopterMode) -> bool:
        """Enter a mode, as the pilot or the vehicle itself does; whether it was entered."""
        return self.modes.enter(mode)

    def disarm(self) -> None:
        """Stop the motors."""
        self.arming.disarm()
