"""The autopilot: modes, arming, home, and what it says; no I/O, and no clock but the vehicle's.

Messages come in decoded (``handle``), go out to the channels that the endpoint attached, and time
passes only in ``step``. The behaviour is ArduCopter 4.6's; the flight model is ``flight.py``'s.
"""

from __future__ import annotations

import math

from flight_replay.mavlink import Message, dialect
from flight_replay.simulator.autopilot.arming import Arming
from flight_replay.simulator.autopilot.battery import Battery
from flight_replay.simulator.autopilot.ekf_frame import LocalMap
from flight_replay.simulator.autopilot.failsafes import Failsafes
from flight_replay.simulator.autopilot.fault_script import Happenings
from flight_replay.simulator.autopilot.faults import Faults
from flight_replay.simulator.autopilot.location import HomePlace, Metres, Place, Start
from flight_replay.simulator.autopilot.mission_control import MissionControl
from flight_replay.simulator.autopilot.mode_switch import ModeSwitch
from flight_replay.simulator.autopilot.model_flight import STEP_S, ModelFlight
from flight_replay.simulator.autopilot.modes import Mode
from flight_replay.simulator.autopilot.parameter_table import Parameter, Parameters
from flight_replay.simulator.autopilot.prearm import Prearm
from flight_replay.simulator.autopilot.sensors import Sensors
from flight_replay.simulator.autopilot.station import Channel, Sender
from flight_replay.simulator.mission.store import MissionStore
from flight_replay.simulator.protocol import telemetry
from flight_replay.simulator.protocol.dispatch import HANDLERS
from flight_replay.simulator.protocol.mission_protocol import MissionProtocol

CRITICAL, WARNING, INFO = 2, 4, 6
_TEXT_LENGTH = 50


class Autopilot:
    """One simulated ArduCopter; ``unix_s`` is the wall clock's time at boot, for SYSTEM_TIME only."""

    def __init__(
        self,
        start: Start,
        *,
        parameters: Parameters | None = None,
        faults: Faults | None = None,
        unix_s: float = 0.0,
    ) -> None:
        self.faults = faults or Faults()
        self.parameters = parameters or self.faults.personality.table()
        self.channels: list[Channel] = []
        self._unix_s = unix_s
        self._long_texts = 0
        self._texts: list[Message] = []
        for name, value in (
            ("SIM_OPOS_LAT", start.lat_deg),
            ("SIM_OPOS_LNG", start.lon_deg),
            ("SIM_OPOS_ALT", start.alt_amsl_m),
            ("SIM_OPOS_HDG", start.heading_deg),
        ):
            self.parameters.assign(name, value)
        self.parameters.changed.append(self._parameter_changed)
        self.store = MissionStore(lambda: self.local.home_item, self._mission_counted)
        self.happenings = Happenings(self)
        self.boot(start)

    def boot(self, at: Start) -> None:
        """Start anew at a place: everything is forgotten but the parameters and the mission."""
        self._steps = 0
        self.local = LocalMap(at)
        self.modes = ModeSwitch(self)
        self.drifts_until_s = math.inf
        self.sensors = Sensors()
        self.battery = Battery(self.parameters)
        self.flight = ModelFlight(self)
        self.mission = MissionControl(self)
        self.arming = Arming(self)
        self.failsafes = Failsafes(self)
        self.prearm = Prearm(self)
        self.protocol = MissionProtocol(self.store, self, self.faults.mission)
        self._warned: set[str] = set()
        self.happenings.note("boot")

    def reboot(self) -> None:
        """Start anew where it is; what flies falls."""
        place, yaw_rad = self.place, self.flight.attitude_rad[2]
        ground_m = self.start.alt_amsl_m
        self.boot(Start(place.lat_e7 / 1e7, place.lon_e7 / 1e7, ground_m, math.degrees(yaw_rad)))
        for channel in self.channels:
            channel.restart()

    # time

    def step(self) -> None:
        """Let STEP_S seconds of the vehicle's time pass."""
        self._steps += 1
        for text in self._texts:
            self.broadcast(text)
        self._texts.clear()
        for text in self.sensors.advance(self.time_s):
            self.say(INFO, text)
        self.sensors.gps_disabled = bool(self.parameters["SIM_GPS_DISABLE"])
        if self.home is None and self.sensors.origin_set:
            self.set_home((0.0, 0.0, 0.0))
            self.say(INFO, f"Field Elevation Set: {self.start.alt_amsl_m:.0f}m")
        if self.mode == Mode.GUIDED and self.time_s > self.drifts_until_s:
            self.drifts_until_s = math.inf
            self.flight.stop()
        self.flight.step()
        self.mission.update()
        self.arming.update()
        self.battery.draw(
            STEP_S, armed=self.armed, landed=self.flight.landed, climb_m_s=self.flight.velocity_m_s[2]
        )
        self.failsafes.update()
        self.prearm.update()
        self.protocol.update()
        self.happenings.update()

    @property
    def time_s(self) -> float:
        """Seconds since boot, by the vehicle's clock."""
        return self._steps * STEP_S

    @property
    def unix_us(self) -> int:
        """The time that GPS gives, µs since 1970."""
        return int((self._unix_s + self.time_s) * 1e6)

    # talking

    def say(self, severity: int, text: str) -> None:
        """A STATUSTEXT to every station, behind the answers that are due now (GCS::service_statustext).

        A long one comes in chunks under a common number.
        """
        data = text.encode()
        if len(data) > _TEXT_LENGTH:
            self._long_texts = self._long_texts % 65535 + 1
        number = self._long_texts if len(data) > _TEXT_LENGTH else 0
        for chunk, begin in enumerate(range(0, len(data), _TEXT_LENGTH)):
            part = data[begin : begin + _TEXT_LENGTH]
            self._texts.append(dialect.MAVLink_statustext_message(severity, part, number, chunk))

    def warn_once(self, text: str) -> None:
        """A warning that is spoken once a boot."""
        if text not in self._warned:
            self._warned.add(text)
            self.say(WARNING, text)

    def broadcast(self, message: Message) -> None:
        """A message to every station."""
        for channel in self.channels:
            channel.send(message)

    def _parameter_changed(self, parameter: Parameter) -> None:
        for channel in self.channels:
            channel.send_parameter(parameter, 65535)
        self.flight.parameters_changed()

    def _mission_counted(self, count: int) -> None:
        self.parameters.assign("MIS_TOTAL", count)

    # places

    @property
    def start(self) -> Start:
        """Where it was booted, which is the EKF's origin."""
        return self.local.start

    @property
    def home(self) -> HomePlace | None:
        """Home, once the EKF has an origin."""
        return self.local.home

    @property
    def place(self) -> Place:
        """Where the copter is."""
        return self.start.place_of(self.flight.position_m)

    @property
    def above_home_m(self) -> float:
        """Height above home."""
        return self.flight.position_m[2] - (self.home.position_m[2] if self.home else 0.0)

    def move_home(self, position_m: Metres) -> None:
        """Home, and the point that RTL flies to, become another place."""
        self.flight.move_home(position_m)
        self.set_home(position_m)

    def set_home(self, position_m: Metres) -> None:
        """Home is a place, and all stations hear of it."""
        self.local.set_home(position_m)
        self.broadcast(telemetry.gps_global_origin(self))
        self.broadcast(telemetry.home_position(self))

    # mission

    @property
    def mission_seq(self) -> int:
        """The item that is flown."""
        return self.mission.seq

    def clear_mission(self) -> bool:
        """Forget where the mission was; False while it is flown."""
        return self.mission.clear()

    # modes and motors

    @property
    def armed(self) -> bool:
        """Whether the motors are armed."""
        return self.arming.armed

    @property
    def mode(self) -> Mode:
        """The flight mode."""
        return self.modes.mode

    def request_mode(self, number: int) -> bool:
        """A station asks for a mode by its number; whether it was entered."""
        return self.modes.request(number)

    def set_mode(self, mode: Mode) -> bool:
        """The pilot or the vehicle itself chooses a mode; whether it was entered."""
        return self.modes.enter(mode)

    def disarm(self) -> None:
        """Stop the motors."""
        self.arming.disarm()

    # messages

    def handle(self, message: Message, sender: Sender) -> None:
        """Act on a message addressed to this vehicle, or to everybody."""
        handler = HANDLERS.get(message.get_type())
        if handler is not None and handler(self, message, sender):
            return
        answer = self.protocol.handlers.get(message.get_type())
        if answer is not None:
            answer(message, sender)
