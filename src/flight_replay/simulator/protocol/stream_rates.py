"""Which messages are streamed over a link, and how often, by the vehicle's clock.

The groups are ArduCopter's (GCS_Mavlink.cpp); a rate requested for a group replaces those of its
messages, and the other way round.
"""

from __future__ import annotations

from flight_replay.mavlink import dialect


def _ids(*names: str) -> tuple[int, ...]:
    return tuple(int(getattr(dialect, f"MAVLINK_MSG_ID_{name}")) for name in names)


GROUPS: dict[int, tuple[int, ...]] = {
    dialect.MAV_DATA_STREAM_RAW_SENSORS: _ids(
        "RAW_IMU", "SCALED_IMU2", "SCALED_IMU3", "SCALED_PRESSURE", "SCALED_PRESSURE2"
    ),
    dialect.MAV_DATA_STREAM_EXTENDED_STATUS: _ids(
        "SYS_STATUS", "POWER_STATUS", "MEMINFO", "MISSION_CURRENT", "GPS_RAW_INT",
        "NAV_CONTROLLER_OUTPUT", "FENCE_STATUS", "POSITION_TARGET_GLOBAL_INT",
    ),
    dialect.MAV_DATA_STREAM_RC_CHANNELS: _ids("SERVO_OUTPUT_RAW", "RC_CHANNELS", "RC_CHANNELS_RAW"),
    dialect.MAV_DATA_STREAM_RAW_CONTROLLER: (),
    dialect.MAV_DATA_STREAM_POSITION: _ids("GLOBAL_POSITION_INT", "LOCAL_POSITION_NED"),
    dialect.MAV_DATA_STREAM_EXTRA1: _ids("ATTITUDE", "SIMSTATE", "AHRS2"),
    dialect.MAV_DATA_STREAM_EXTRA2: _ids("VFR_HUD"),
    dialect.MAV_DATA_STREAM_EXTRA3: _ids(
        "AHRS", "SYSTEM_TIME", "WIND", "BATTERY_STATUS", "EKF_STATUS_REPORT", "VIBRATION"
    ),
}  # fmt: skip
"""Message numbers by MAV_DATA_STREAM."""

_HEARTBEAT = dialect.MAVLINK_MSG_ID_HEARTBEAT
_HEARTBEAT_S = 1.0


class StreamRates:
    """When each message is due next; times are seconds since boot."""

    def __init__(self, rates_hz: dict[int, float]) -> None:
        self._group_hz = dict(rates_hz)
        self._interval_s: dict[int, float] = {_HEARTBEAT: _HEARTBEAT_S}
        self._due_s: dict[int, float] = {_HEARTBEAT: 0.0}
        self._earliest_s = 0.0
        for group in self._group_hz:
            self._apply_group(group)

    def interval_s(self, message_id: int) -> float | None:
        """Seconds between two messages of a number, None if it is not streamed."""
        return self._interval_s.get(message_id)

    def set_group(self, group: int, rate_hz: float) -> None:
        """Stream a group's messages ``rate_hz`` times a second; group 0 is every group."""
        for each in GROUPS if group == dialect.MAV_DATA_STREAM_ALL else [group]:
            self._group_hz[each] = rate_hz
            self._apply_group(each)

    def _apply_group(self, group: int) -> None:
        rate_hz = self._group_hz[group]
        for message_id in GROUPS.get(group, ()):
            self._set(message_id, 1 / rate_hz if rate_hz > 0 else None)

    def set_message(self, message_id: int, interval_s: float | None) -> None:
        """Stream a message every so many seconds; None stops it, 0 resets it to its group's rate."""
        if interval_s == 0:
            group = next((each for each, ids in GROUPS.items() if message_id in ids), None)
            rate_hz = self._group_hz.get(group, 0.0) if group is not None else 0.0
            interval_s = 1 / rate_hz if rate_hz > 0 else None
            if message_id == _HEARTBEAT:
                interval_s = _HEARTBEAT_S
        self._set(message_id, interval_s)

    def _set(self, message_id: int, interval_s: float | None) -> None:
        if interval_s is None:
            self._interval_s.pop(message_id, None)
            self._due_s.pop(message_id, None)
            return
        self._interval_s[message_id] = interval_s
        self._due_s[message_id] = 0.0
        self._earliest_s = 0.0

    def due(self, time_s: float) -> list[int]:
        """The messages that are due; one that is late is sent once, and those missed are left out."""
        if time_s < self._earliest_s:
            return []
        ready = [message_id for message_id, at_s in self._due_s.items() if at_s <= time_s]
        for message_id in ready:
            interval_s = self._interval_s[message_id]
            late = time_s - self._due_s[message_id] >= interval_s
            self._due_s[message_id] = (time_s if late else self._due_s[message_id]) + interval_s
        self._earliest_s = min(self._due_s.values(), default=time_s)
        return ready
