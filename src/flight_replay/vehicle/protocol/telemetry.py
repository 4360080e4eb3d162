"""What the vehicle sends, as news for the supervisor.

Runs on the link's thread; news waits in a queue until the supervisor takes it. Only the vehicle
that is flown is heard: gimbals, radios and neighbours share the link.
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
    MissionCurrent,
    MissionItemReached,
    PrearmStatus,
    Rebooted,
    Report,
)
from flight_replay.vehicle.protocol.commands import Commands

_KEPT = 50_000  # Report that nobody takes: minutes of a fast simulator.
_LATE_REPORTS = 5  # So many reports in a row from before the newest one ...
_LATE_WALL_S = 0.5  # ... and nothing newer for this time here: a reboot, not packets out of order.
_COPIES_WITHIN = 64  # Messages; packets are numbered up to 255, so one sent anew is not taken for a copy ...
_COPIES_WITHIN_S = 0.9  # ... nor one of an autopilot that does not number them, whose heartbeats are alike.
_NO_TOTAL = frozenset({0, 65535})  # MISSION_CURRENT.total where it is not told.
_PREARM = dialect.MAV_SYS_STATUS_PREARM_CHECK
_UNKNOWN_HEADING = 65535


def _readable(text: str) -> str:
    """Words on one line, without what would command the terminal that shows them."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


class Telemetry:
    """Turns messages into news; ``drone`` is the DroneKit vehicle that was handed each of them before."""

    def __init__(self, system: int, component: int, drone: Any, commands: Commands) -> None:
        self._source = (system, component)
        self._drone = drone
        self._commands = commands
        self._news: deque[Report] = deque(maxlen=_KEPT)
        self._arrived = threading.Condition()
        self._mode, self._armed = "", False
        self._newest_s = self._newer_s = self._position_s = float("-inf")
        self._late = 0
        self._frames: deque[tuple[bytes, float]] = deque(maxlen=_COPIES_WITHIN)  # And when they came.
        self.heard_s: dict[str, float] = {}  # When a message of each kind came last, by the clock here.
        self._prearm_known = self._prearm_good = False
        self._text: dict[int, list[str]] = {}
        self._handlers: dict[str, Callable[[Message], Report | None]] = {
            "HEARTBEAT": self._heartbeat,
            "GLOBAL_POSITION_INT": self._position,
            "STATUSTEXT": self._status_text,
            "COMMAND_ACK": commands.answer,
            "TIMESYNC": commands.echoed,
            "MISSION_CURRENT": self._mission_current,
            "MISSION_ITEM_REACHED": lambda message: MissionItemReached(message.seq),
            "SYS_STATUS": self._system_status,
            "EKF_STATUS_REPORT": lambda message: self._readiness(),
        }

    def receive(self, message: Message) -> None:
        """Take in a message, on the link's thread."""
        if (message.get_srcSystem(), message.get_srcComponent()) != self._source or self._is_copy(message):
            return
        self.heard_s[message.get_type()] = time.monotonic()
        handler = self._handlers.get(message.get_type())
        news = (self._reboot(message), handler(message) if handler else None)
        with self._arrived:
            self._news += [item for item in news if item is not None]
            self._arrived.notify_all()

    def _is_copy(self, message: Message) -> bool:
        """Whether a link that doubles packets brought this one before, by its number and all the rest."""
        frame, now_s = bytes(message.get_msgbuf()), time.monotonic()
        while self._frames and now_s - self._frames[0][1] > _COPIES_WITHIN_S:
            self._frames.popleft()
        if any(frame == known for known, _ in self._frames):
            return True
        self._frames.append((frame, now_s))
        return False

    def take(self, timeout_s: float) -> Sequence[Report]:
        """All news since the last call, waiting for the first until the timeout."""
        with self._arrived:
            if not self._news:
                self._arrived.wait_for(lambda: bool(self._news), timeout_s)
            news = tuple(self._news)
            self._news.clear()
        return news

    def _reboot(self, message: Message) -> Report | None:
        """Whether the vehicle's clock, which many messages tell, has begun anew."""
        time_ms = getattr(message, "time_boot_ms", None)
        if time_ms is None:
            return None
        now_s = time.monotonic()
        if time_ms / 1e3 < self._newest_s:
            self._late += 1
            if self._late < _LATE_REPORTS or now_s - self._newer_s < _LATE_WALL_S:
                return None
            self._position_s = float("-inf")
            self._newest_s, self._newer_s, self._late = time_ms / 1e3, now_s, 0
            return Rebooted()
        self._newest_s, self._newer_s, self._late = time_ms / 1e3, now_s, 0
        return None

    def _heartbeat(self, message: Message) -> Report:
        self._mode = mode_name(message.custom_mode)
        self._armed = bool(message.base_mode & dialect.MAV_MODE_FLAG_SAFETY_ARMED)
        return Heartbeat(self._mode, self._armed)

    def _position(self, message: Message) -> Report | None:
        time_s = message.time_boot_ms / 1e3
        if time_s < self._position_s or not self._mode or (message.lat == 0 and message.lon == 0):
            return None  # Overtaken on the way, before the first heartbeat, or no position yet.
        self._position_s = time_s
        battery = self._drone.battery
        return VehicleState(
            time_s=time_s,
            lat_deg=message.lat / 1e7,
            lon_deg=message.lon / 1e7,
            alt_m=message.relative_alt / 1e3,
            velocity_m_s=(message.vx / 1e2, message.vy / 1e2, -message.vz / 1e2),
            heading_deg=None if message.hdg == _UNKNOWN_HEADING else message.hdg / 1e2,
            mode=self._mode,
            armed=self._armed,
            battery_v=battery.voltage if battery else None,
            battery_percent=battery.level if battery and (battery.level or 0) >= 0 else None,
        )

    def _status_text(self, message: Message) -> Report | None:
        """A text; MAVLink 2 sends long ones in pieces of 50 with a common ``id``."""
        text_id = getattr(message, "id", 0)
        if text_id == 0:
            return StatusText(message.severity, _readable(message.text))
        if message.chunk_seq == 0:
            self._text[text_id] = []  # An earlier text of that number lost its end on the way.
        pieces = self._text.setdefault(text_id, [])
        pieces.append(message.text)
        if len(message.text) == 50:
            return None
        del self._text[text_id]
        return StatusText(message.severity, _readable("".join(pieces)))

    def _mission_current(self, message: Message) -> Report:
        total = getattr(message, "total", 0)
        complete = getattr(message, "mission_state", 0) == dialect.MISSION_STATE_COMPLETE
        return MissionCurrent(message.seq, None if total in _NO_TOTAL else total, complete)

    def _system_status(self, message: Message) -> Report:
        self._prearm_known = bool(message.onboard_control_sensors_enabled & _PREARM)
        self._prearm_good = bool(message.onboard_control_sensors_health & _PREARM)
        return self._readiness()

    def _readiness(self) -> PrearmStatus:
        """Position and estimator as DroneKit sees them, and the autopilot's own checks since 4.0."""
        gps = self._drone.gps_0
        if not self._drone.is_armable:
            fix = gps.fix_type or 0
            return PrearmStatus(
                False, "no GPS fix yet" if fix < dialect.GPS_FIX_TYPE_3D_FIX else "no position estimate yet"
            )
        if self._prearm_known and not self._prearm_good:
            return PrearmStatus(False, "its checks before arming do not pass yet")
        return PrearmStatus(True)
