"""Turns the vehicle's messages into reports for the supervisor.

Runs on the link's thread; reports wait in a queue until the supervisor takes them.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

from flight_replay.events import StatusText, VehicleState
from flight_replay.flight_modes import mode_name
from flight_replay.mavlink import Message, dialect
from flight_replay.supervisor.vehicle_interface import (
    Heartbeat,
    HomePosition,
    MissionCurrent,
    MissionItemReached,
    PrearmStatus,
    Rebooted,
    Report,
)
from flight_replay.vehicle.protocol.commands import CommandSender

_QUEUED_REPORTS = 50_000  # Minutes of a fast simulator.
_MIN_OLD_TIMES = 5  # So many older times in a row ...
_MIN_OLD_WALL_S = 0.5  # ... and no newer one for so long mean a reboot, not packets out of order; ...
_MOST_BETWEEN_WALL_S = 0.125  # ... while nothing is read, a newer one may be waiting.
_DUPLICATE_FRAMES = 64  # Sequence numbers go up to 255, so a frame sent anew is not taken for a duplicate ...
_DUPLICATE_S = 0.9  # ... nor is the next heartbeat of an autopilot that does not number its frames.
_TOTAL_UNKNOWN = frozenset({0, 65535})  # Values of MISSION_CURRENT.total.
_PREARM = dialect.MAV_SYS_STATUS_PREARM_CHECK
_GPS, _EKF = "GPS_RAW_INT", "EKF_STATUS_REPORT"
_ENOUGH_SATELLITES = 6  # With fewer, ArduPilot's EKF does not begin to use a GPS.
_UNKNOWN_HEADING = 65535
_HOME_STEP_M = 1.0  # Between two positions nothing else changes the height of home so much.
_UNKNOWN_V = 65.535  # UINT16_MAX millivolts; without a battery monitor ArduPilot sends 0.


def _printable(text: str) -> str:
    """The text on one line, without control characters: they would act on the terminal."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


class Telemetry:
    """Turns messages into reports; ``drone`` is the DroneKit vehicle, which processes each message first."""

    def __init__(self, drone: Any, commands: CommandSender) -> None:
        self._drone = drone
        self._reports: deque[Report] = deque(maxlen=_QUEUED_REPORTS)
        self._changed = threading.Condition()
        self._mode, self._armed = "", False
        self._last_heartbeat: tuple[Heartbeat, float] | None = None  # With its wall-clock time.
        self._home_amsl_m: float | None = None  # While the vehicle is armed.
        self._home_rose_m = 0.0
        self._newest_s = self._timed_wall_s = self._position_s = float("-inf")
        self._old_times, self._old_wall_s = 0, 0.0
        self._frames: deque[tuple[bytes, float]] = deque(maxlen=_DUPLICATE_FRAMES)  # With wall-clock times.
        self.received_s: dict[str, float] = {}
        """Wall-clock time of the last message of each type."""
        self._prearm_reported = self._prearm_ok = False
        self._chunks: dict[int, list[str]] = {}
        self._handlers: dict[str, Callable[[Message], Report | None]] = {
            "HEARTBEAT": self._heartbeat,
            "GLOBAL_POSITION_INT": self._position,
            "STATUSTEXT": self._status_text,
            "COMMAND_ACK": commands.on_ack,
            "TIMESYNC": commands.on_timesync,
            "MISSION_CURRENT": self._mission_current,
            "MISSION_ITEM_REACHED": lambda message: MissionItemReached(message.seq),
            "HOME_POSITION": lambda message: HomePosition(
                message.latitude / 1e7, message.longitude / 1e7, message.altitude / 1e3
            ),
            "SYS_STATUS": self._system_status,
            _EKF: lambda message: self._prearm_status(),
        }

    def receive(self, message: Message) -> None:
        """Process a message of the vehicle, on the link's thread."""
        if self._is_duplicate(message):
            return
        self.received_s[message.get_type()] = time.monotonic()
        handler = self._handlers.get(message.get_type())
        reports = (self._reboot(message), handler(message) if handler else None)
        with self._changed:
            self._reports += [report for report in reports if report is not None]
            self._changed.notify_all()

    def _is_duplicate(self, message: Message) -> bool:
        """Whether the same frame, its sequence number included, was received just before."""
        frame, now_s = bytes(message.get_msgbuf()), time.monotonic()
        while self._frames and now_s - self._frames[0][1] > _DUPLICATE_S:
            self._frames.popleft()
        if any(frame == known for known, _ in self._frames):
            return True
        self._frames.append((frame, now_s))
        return False

    def reports(self, timeout_s: float) -> Sequence[Report]:
        """All reports since the last call; waits up to the timeout for the first."""
        with self._changed:
            if not self._reports:
                self._changed.wait_for(lambda: bool(self._reports), timeout_s)
            reports = tuple(self._reports)
            self._reports.clear()
        return reports

    def heartbeat(self, max_age_s: float, timeout_s: float = 0.0) -> Heartbeat | None:
        """The last heartbeat, or the next if that is older; None if none comes within the timeout."""

        def last() -> Heartbeat | None:
            if self._last_heartbeat is None or time.monotonic() - self._last_heartbeat[1] > max_age_s:
                return None
            return self._last_heartbeat[0]

        with self._changed:
            return self._changed.wait_for(last, timeout_s)

    def _reboot(self, message: Message) -> Report | None:
        """``Rebooted`` if the vehicle's clock, which many messages contain, has restarted."""
        time_ms = getattr(message, "time_boot_ms", None)
        if time_ms is None:
            return None
        now_s = time.monotonic()
        between_s, self._timed_wall_s = now_s - self._timed_wall_s, now_s
        rebooted = None
        if time_ms / 1e3 < self._newest_s:
            self._old_times += 1
            self._old_wall_s += min(between_s, _MOST_BETWEEN_WALL_S)
            if self._old_times < _MIN_OLD_TIMES or self._old_wall_s < _MIN_OLD_WALL_S:
                return None
            self._position_s = float("-inf")
            rebooted = Rebooted()
        self._newest_s, self._old_times, self._old_wall_s = time_ms / 1e3, 0, 0.0
        return rebooted

    def _heartbeat(self, message: Message) -> Report:
        self._mode = mode_name(message.custom_mode)
        self._armed = bool(message.base_mode & dialect.MAV_MODE_FLAG_SAFETY_ARMED)
        heartbeat = Heartbeat(self._mode, self._armed)
        self._last_heartbeat = heartbeat, time.monotonic()
        return heartbeat

    def _position(self, message: Message) -> Report | None:
        time_s = message.time_boot_ms / 1e3
        if time_s < self._position_s or not self._mode or (message.lat == 0 and message.lon == 0):
            return None  # Out of order, before the first heartbeat, or no position yet.
        self._position_s = time_s
        battery = self._drone.battery
        return VehicleState(
            time_s=time_s,
            lat_deg=message.lat / 1e7,
            lon_deg=message.lon / 1e7,
            alt_m=message.relative_alt / 1e3 + self._home_rise_m(message),
            velocity_m_s=(message.vx / 1e2, message.vy / 1e2, -message.vz / 1e2),
            heading_deg=None if message.hdg == _UNKNOWN_HEADING else message.hdg / 1e2,
            mode=self._mode,
            armed=self._armed,
            battery_v=battery.voltage if battery and 0 < battery.voltage < _UNKNOWN_V else None,
            battery_percent=battery.level if battery and (battery.level or 0) >= 0 else None,
        )

    def _home_rise_m(self, message: Message) -> float:
        """How much higher home is than when the vehicle was armed: who moves it does not move the vehicle."""
        home_m = (message.alt - message.relative_alt) / 1e3
        if self._armed and self._home_amsl_m is None:
            self._home_rose_m = 0.0
        elif self._home_amsl_m is not None and self._armed and abs(home_m - self._home_amsl_m) > _HOME_STEP_M:
            self._home_rose_m += home_m - self._home_amsl_m
        self._home_amsl_m = home_m if self._armed else None
        return self._home_rose_m

    def _status_text(self, message: Message) -> Report | None:
        """A text; MAVLink 2 sends long ones in chunks of 50 characters with a common ``id``."""
        text_id = getattr(message, "id", 0)
        if text_id == 0:
            return StatusText(message.severity, _printable(message.text))
        if message.chunk_seq == 0:
            self._chunks[text_id] = []  # The end of an earlier text with this id was lost.
        chunks = self._chunks.setdefault(text_id, [])
        chunks.append(message.text)
        if len(message.text) == 50:
            return None
        del self._chunks[text_id]
        return StatusText(message.severity, _printable("".join(chunks)))

    def _mission_current(self, message: Message) -> Report:
        total = getattr(message, "total", 0)
        complete = getattr(message, "mission_state", 0) == dialect.MISSION_STATE_COMPLETE
        return MissionCurrent(message.seq, None if total in _TOTAL_UNKNOWN else total, complete)

    def _system_status(self, message: Message) -> Report:
        self._prearm_reported = bool(message.onboard_control_sensors_enabled & _PREARM)
        self._prearm_ok = bool(message.onboard_control_sensors_health & _PREARM)
        return self._prearm_status()

    def _prearm_status(self) -> PrearmStatus:
        """Position and EKF as DroneKit reports them, and the autopilot's pre-arm checks (since 4.0)."""
        if not self._drone.is_armable:
            return PrearmStatus(False, self._missing())
        if self._prearm_reported and not self._prearm_ok:
            return PrearmStatus(False, "pre-arm checks fail")
        return PrearmStatus(True)

    def _missing(self) -> str:
        """What the position needs that is not there."""
        if (self._drone.gps_0.fix_type or 0) < dialect.GPS_FIX_TYPE_3D_FIX:
            return "no GPS fix yet" if _GPS in self.received_s else f"no {_GPS} message yet"
        if _EKF not in self.received_s:
            return f"no {_EKF} message yet"
        satellites = self._drone.gps_0.satellites_visible
        few = satellites is not None and satellites < _ENOUGH_SATELLITES
        return "no EKF position estimate yet" + (f", with {satellites} satellites only" if few else "")
