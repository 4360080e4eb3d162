"""Flies a mission in a real ArduCopter SITL and records it: pymavlink and a subprocess, nothing else."""

from __future__ import annotations

import socket
import subprocess
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any

from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega as dialect

from flight_replay.mission.items import Home, Mission, MissionItem

GUIDED, AUTO, RTL = 4, 3, 6
_PREARM = dialect.MAV_SYS_STATUS_PREARM_CHECK
_EKF_READY = dialect.EKF_ATTITUDE | dialect.EKF_POS_HORIZ_ABS
_SILENT_S = 30.0
_STAY_S = 4.0
_SPEEDUP = "10"
_GAINS = ("PSC_VELXY_D", "PSC_NE_VEL_D")
"""By which versions differ: one of the two names is that of the vehicle."""
_AGAIN_S = 0.3  # By the wall clock: before the first message the vehicle's is unknown.


@dataclass(slots=True)
class Recorded:
    """Seconds since boot, degrees, and metres above home at 10 Hz, and when things happened."""

    rows: list[tuple[float, float, float, float]] = field(default_factory=list)
    reached_s: dict[int, float] = field(default_factory=dict)
    armed_s: float = 0.0
    high_s: float = 0.0
    auto_s: float = 0.0
    rtl_s: float = 0.0
    disarmed_s: float = 0.0


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


class SitlFlight:
    """One ArduCopter process and the link to it; time is the vehicle's own."""

    def __init__(
        self,
        binary: Path,
        defaults: Path,
        folder: Path,
        home: Home,
        parameters: Mapping[str, float],
    ) -> None:
        extra = folder / "extra.parm"
        extra.write_text("".join(f"{name} {value}\n" for name, value in parameters.items()))
        port = free_port()
        place = f"{home.lat_deg:.7f},{home.lon_deg:.7f},{home.alt_amsl_m:g},0"
        command = [str(binary), "--model", "+", "--home", place, "--speedup", _SPEEDUP, "-w"]
        command += ["--base-port", str(port), "--defaults", f"{defaults},{extra}"]
        self._output = (folder / "sitl.log").open("wb")
        self._process = subprocess.Popen(
            command, cwd=folder, stdin=subprocess.DEVNULL, stdout=self._output, stderr=subprocess.STDOUT
        )
        self._link: Any = None
        self.time_s = 0.0
        self.flown = Recorded()
        self.parameters = dict(parameters)
        """Those that were set, and the gains that are not the same in all versions."""
        self._seen: dict[str, Any] = {}
        self._recording = False
        self._mode, self._mode_s = -1, 0.0
        self._connect(port)

    def _connect(self, port: int) -> None:
        end = time.monotonic() + _SILENT_S
        while self._link is None:
            assert self._process.poll() is None, "SITL has ended"
            assert time.monotonic() < end, "SITL does not listen"
            try:
                self._link = mavutil.mavlink_connection(f"tcp:127.0.0.1:{port}", source_system=255, retries=0)
            except OSError:
                time.sleep(0.1)

    def __enter__(self) -> SitlFlight:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._link is not None:
            self._link.close()
        self._process.kill()
        self._process.wait()
        self._output.close()

    # messages

    def _send(self, message: Any) -> None:
        self._link.mav.send(message)

    def _command(self, number: int, *values: float) -> None:
        padded = [*values, *[0.0] * (7 - len(values))]
        self._send(dialect.MAVLink_command_long_message(1, 1, number, 0, *padded))

    def _take(self) -> Any:
        """The next message; keeps what matters."""
        message = self._link.recv_match(blocking=True, timeout=_SILENT_S)
        assert message is not None, "SITL is silent"
        kind = message.get_type()
        self._seen[kind] = message
        if kind == "GLOBAL_POSITION_INT":
            self.time_s = message.time_boot_ms * 1e-3
            if self._recording:
                place = message.lat * 1e-7, message.lon * 1e-7, message.relative_alt * 1e-3
                self.flown.rows.append((self.time_s, *place))
        elif kind == "HEARTBEAT" and message.custom_mode != self._mode:
            self._mode, self._mode_s = message.custom_mode, self.time_s
        elif kind == "MISSION_ITEM_REACHED":
            self.flown.reached_s[message.seq] = self.time_s
        elif kind == "PARAM_VALUE" and message.param_id in _GAINS:
            self.parameters[message.param_id] = message.param_value
        return message

    def _until(
        self, done: Callable[[], bool], what: str, limit_s: float, do: Callable[[], None] | None = None
    ) -> None:
        """Take messages until ``done``; ``do`` what is needed, again and again."""
        begin, again = self.time_s, 0.0
        wall_end = time.monotonic() + 60 + limit_s
        while not done():
            if do is not None and time.monotonic() >= again:
                do()
                again = time.monotonic() + _AGAIN_S
            self._take()
            late = self.time_s > begin + limit_s or time.monotonic() > wall_end
            assert not late, f"no {what} within {limit_s} s"

    def _heartbeat(self) -> Any:
        return self._seen.get("HEARTBEAT")

    def _in_mode(self, mode: int) -> bool:
        return self._mode == mode

    def _armed(self) -> bool:
        return bool(self._heartbeat().base_mode & dialect.MAV_MODE_FLAG_SAFETY_ARMED)

    @property
    def version(self) -> tuple[int, ...]:
        """Of the firmware, and how mature it is, such as (4, 6, 0, 255)."""
        packed = self._seen["AUTOPILOT_VERSION"].flight_sw_version
        return tuple(packed >> shift & 0xFF for shift in (24, 16, 8, 0))

    # the flight

    def fly(self, mission: Mission) -> Recorded:
        """Arm and take off in GUIDED, AUTO to the last item, some seconds more, RTL until disarmed."""
        self._until(self._ready, "readiness to arm", 180.0, self._ask)
        self._upload(mission)
        self._set_mode(GUIDED)
        up = next(item.alt_m for item in mission.items if item.is_waypoint)
        self._recording = True
        self._until(
            self._armed, "arming", 20.0, lambda: self._command(dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)
        )
        self.flown.armed_s = self.time_s
        take_off = dialect.MAV_CMD_NAV_TAKEOFF
        self._command(take_off, 0, 0, 0, 0, 0, 0, up)
        self._until(lambda: self._high(0.95 * up), "take-off", 120.0)
        self.flown.high_s = self.time_s
        self._set_mode(AUTO)
        self.flown.auto_s = self._mode_s
        last = max(seq for seq, _ in mission.waypoints)
        self._until(lambda: last in self.flown.reached_s, "end of the mission", 1800.0)
        end_s = self.time_s + _STAY_S
        self._until(lambda: self.time_s >= end_s, "time", 10.0)
        self._set_mode(RTL)
        self.flown.rtl_s = self._mode_s
        self._until(lambda: not self._armed(), "landing", 300.0)
        self.flown.disarmed_s = self.time_s
        return self.flown

    def _high(self, up_m: float) -> bool:
        position = self._seen.get("GLOBAL_POSITION_INT")
        return position is not None and position.relative_alt * 1e-3 >= up_m

    def _ask(self) -> None:
        """Ask for what is needed to judge and record, ten times a second."""
        for number in (0, 1, 33, 193):
            self._command(dialect.MAV_CMD_SET_MESSAGE_INTERVAL, number, 100_000)
        self._command(dialect.MAV_CMD_REQUEST_MESSAGE, dialect.MAVLINK_MSG_ID_AUTOPILOT_VERSION)
        for name in _GAINS:
            self._send(dialect.MAVLink_param_request_read_message(1, 1, name.encode(), -1))

    def _ready(self) -> bool:
        status, estimate = self._seen.get("SYS_STATUS"), self._seen.get("EKF_STATUS_REPORT")
        if status is None or estimate is None or self._heartbeat() is None:
            return False
        if "AUTOPILOT_VERSION" not in self._seen or self.parameters.keys().isdisjoint(_GAINS):
            return False
        return (
            bool(status.onboard_control_sensors_health & _PREARM)
            and estimate.flags & _EKF_READY == _EKF_READY
        )

    def _set_mode(self, mode: int) -> None:
        self._until(
            lambda: self._in_mode(mode),
            f"mode {mode}",
            20.0,
            lambda: self._command(
                dialect.MAV_CMD_DO_SET_MODE, dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, mode
            ),
        )

    def _upload(self, mission: Mission) -> None:
        home = MissionItem(16, 0, (0.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0)
        items = [home, *mission.items]
        self._seen.pop("MISSION_ACK", None)
        self._send(dialect.MAVLink_mission_count_message(1, 1, len(items)))
        while "MISSION_ACK" not in self._seen:
            message = self._take()
            if message.get_type() in ("MISSION_REQUEST", "MISSION_REQUEST_INT"):
                item = items[message.seq]
                place = round(item.lat_deg * 1e7), round(item.lon_deg * 1e7), item.alt_m
                head = 1, 1, message.seq, item.frame, item.command, 0, 1
                self._send(dialect.MAVLink_mission_item_int_message(*head, *item.params, *place))
        assert self._seen["MISSION_ACK"].type == 0, "mission refused"
