"""Requests the data streams that the supervisor needs, and requests them again when they stop."""

from __future__ import annotations

from flight_replay.mavlink import dialect
from flight_replay.vehicle.link.vehicle_link import VehicleLink
from flight_replay.vehicle.protocol.telemetry import Telemetry

_CHECK_S = 1.0
_STOPPED_S = 3.0  # Both in vehicle time ...
_MIN_WALL_S = 0.3  # ... but no less than this in wall-clock time, for a link that loses packets.
_STREAMS = {
    dialect.MAV_DATA_STREAM_EXTENDED_STATUS: (4, "SYS_STATUS"),
    dialect.MAV_DATA_STREAM_POSITION: (10, "GLOBAL_POSITION_INT"),
    dialect.MAV_DATA_STREAM_EXTRA1: (4, "ATTITUDE"),
    dialect.MAV_DATA_STREAM_EXTRA2: (2, "VFR_HUD"),
    dialect.MAV_DATA_STREAM_EXTRA3: (2, "EKF_STATUS_REPORT"),
}
"""Rate of each stream, Hz of vehicle time (the flown track is made of the positions), and a message of it."""


class StreamRequests:
    """Keeps the streams running: a request may be lost, and a reboot ends them all."""

    def __init__(self, link: VehicleLink, telemetry: Telemetry) -> None:
        """Send requests over ``link`` for what ``telemetry`` does not receive."""
        self._link, self._telemetry = link, telemetry
        self._checked_s = float("-inf")

    def renew(self, speedup: float) -> None:
        """Request the streams that have stopped; ``speedup`` is how fast the vehicle's clock runs."""
        now_s = self._link.now_s()
        if now_s - self._checked_s < max(_CHECK_S / speedup, _MIN_WALL_S):
            return
        self._checked_s = now_s
        stopped_s = max(_STOPPED_S / speedup, _MIN_WALL_S)
        for stream, (rate_hz, message_type) in _STREAMS.items():
            if now_s - self._telemetry.received_s.get(message_type, float("-inf")) >= stopped_s:
                self._link.send(
                    dialect.MAVLink_request_data_stream_message(
                        self._link.system, self._link.component, stream, rate_hz, 1
                    )
                )
