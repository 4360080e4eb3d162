"""The autopilot: modes, arming, home, and what it says; no I/O, and no clock but the vehicle's.

Messages come in decoded (``handle``), go out to the channels that the endpoint attached, and time
passes only in ``step``. The behaviour is ArduCopter 4.6's; the flight model is ``flight.py``'s.
"""

from __future__ import annotations

import math

from flight_replay.simulator import telemetry
from flight_replay.simulator.arming import Arming
from flight_replay.simulator.battery import Battery
from flight_replay.simulator.failsafes import Failsafes
from flight_replay.simulator.faults import Faults
from flight_replay.simulator.flight import STEP_S, ModelFlight
from flight_replay.simulator.happenings import Happenings
from flight_replay.simulator.inbound import HANDLERS
from flight_replay.simulator.mavlink import Channel, Message, Sender, dialect
from flight_replay.simulator.mission_control import MissionControl
from flight_replay.simulator.mission_items import StoredItem
from flight_replay.simulator.mission_protocol import MissionProtocol
from flight_replay.simulator.mission_store import MissionStore
from flight_replay.simulator.modes import NEEDS_POSITION, Mode, is_blocked
from flight_replay.simulator.parameters import Parameter, Parameters
from flight_replay.simulator.place import HomePlace, Metres, Place, Start
from flight_replay.simulator.prearm import Prearm
from flight_replay.simulator.sensors import Sensors

CRITICAL, WARNING, INFO = 2, 4, 6
_TEXT_LENGTH = 50
_WAYPOINT = 16
_ABSOLUTE_FRAMES = frozenset({0, 5})
_RELATIVE_FRAMES = frozenset({3, 6, 10, 11})


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
        self.parameters = parameters or Parameters()
        self.channels: list[Channel] = []
        self._unix_s = unix_s
        self.parameters.changed.append(self._parameter_changed)
        self.store = MissionStore(self._home_item, self._mission_counted)
        self.happenings = Happenings(self)
        self.boot(start)

    def boot(self, at: Start) -> None:
        """Start anew at a place: everything is forgotten but the parameters and the mission."""
        self._steps = 0
        self.start = at
        self.mode = Mode.STABILIZE
        self.home: HomePlace | None = None
        self.drifts_until_s = math.inf
        self.sensors = Sensors()
        self.battery = Battery(self.parameters)
        self.flight = ModelFlight(self)
        self.mission = MissionControl(self)
        self.arming = Arming(self)
        self.failsafes = Failsafes(self)
        self.prearm = Prearm(self)
        self.protocol = MissionProtocol(
            self.store,
            time_s=lambda: self.time_s,
            say=self.say,
            may_clear=self.mission.clear,
            current_seq=lambda: self.mission.seq,
            faults=self.faults.mission,
        )
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
        """A STATUSTEXT to every station; long ones are cut, as ArduPilot's are over MAVLink 1."""
        self.broadcast(dialect.MAVLink_statustext_message(severity, text.encode()[:_TEXT_LENGTH]))

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
    def place(self) -> Place:
        """Where the copter is."""
        return self.place_of(self.flight.position_m)

    def place_of(self, position_m: Metres) -> Place:
        """A place given in metres around where the copter was booted."""
        return self.start.place_of(position_m)

    def metres_of_frame(self, lat_e7: int, lon_e7: int, alt_m: float, frame: int) -> Metres | None:
        """A place whose height counts from sea level, home or the (level) ground; None if it is none."""
        if abs(lat_e7) > 90 * 10**7 or abs(lon_e7) > 180 * 10**7 or not math.isfinite(alt_m):
            return None
        if frame in _ABSOLUTE_FRAMES:
            return self.start.metres_of(lat_e7, lon_e7, alt_m)
        if frame not in _RELATIVE_FRAMES or self.home is None:
            return None
        return self.start.metres_of(lat_e7, lon_e7, alt_m + self.home.alt_cm / 100)

    def metres_from_home(self, lat_e7: int, lon_e7: int) -> tuple[float, float]:
        """North and east of home, metres."""
        north_m, east_m, _ = self.start.metres_of(lat_e7, lon_e7, 0.0)
        home_m = self.home.position_m if self.home else (0.0, 0.0, 0.0)
        return north_m - home_m[0], east_m - home_m[1]

    @property
    def above_home_m(self) -> float:
        """Height above home."""
        return self.flight.position_m[2] - (self.home.position_m[2] if self.home else 0.0)

    def move_home(self, position_m: Metres) -> None:
        """Home and the point that RTL flies to become another place."""
        self.flight.move_home(position_m)
        self.set_home(position_m)

    def set_home(self, position_m: Metres) -> None:
        """Home is a place, and all stations hear of it."""
        place = self.place_of(position_m)
        self.home = HomePlace(place.lat_e7, place.lon_e7, round(place.alt_mm / 10), position_m)
        self.broadcast(telemetry.gps_global_origin(self))
        self.broadcast(telemetry.home_position(self))

    def _home_item(self) -> StoredItem:
        if self.home is None:
            return StoredItem(_WAYPOINT)
        return StoredItem(
            _WAYPOINT, 0, (0.0, 0.0, 0.0, 0.0), self.home.lat_e7, self.home.lon_e7, self.home.alt_cm
        )

    # modes

    @property
    def armed(self) -> bool:
        """Whether the motors are armed."""
        return self.arming.armed

    @property
    def mode_name(self) -> str:
        """The mode as ArduCopter's texts write it: Auto, Land, RTL."""
        return self.mode.name if self.mode == Mode.RTL else self.mode.name.replace("_", "").capitalize()

    def request_mode(self, number: int) -> bool:
        """A station asks for a mode by its number."""
        try:
            mode = Mode(number)
        except ValueError:
            self.say(WARNING, f"No such mode {number}")
            return False
        if is_blocked(mode, int(self.parameters["FLTMODE_GCSBLOCK"])):
            self._mode_refused(mode, "GCS entry disabled (FLTMODE_GCSBLOCK)")
            return False
        reason = self.faults.refused_modes.get(number)
        if reason is not None:
            self._mode_refused(mode, reason)
            return False
        return self.set_mode(mode)

    def _mode_refused(self, mode: Mode, reason: str) -> None:
        self.say(WARNING, f"Mode change to {mode.name} failed: {reason}")

    def set_mode(self, mode: Mode) -> bool:
        """Enter a mode if what it needs is there; on the ground disarmed any mode may be chosen."""
        if mode == self.mode:
            return True
        if self.armed and mode in NEEDS_POSITION and not self.sensors.position_ok:
            self._mode_refused(mode, "requires position")
            return False
        if mode == Mode.AUTO and not self.mission.may_begin():
            self._mode_refused(mode, "init failed")
            return False
        before, self.mode = self.mode, mode
        self.drifts_until_s = math.inf
        if before == Mode.AUTO:
            self.mission.stop()
        self.flight.enter_mode(mode)
        if mode == Mode.AUTO:
            self.mission.wait_to_start()
        self.broadcast(telemetry.heartbeat(self))
        self.happenings.note(mode.name)
        return True

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
