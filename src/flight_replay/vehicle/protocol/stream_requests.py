"""Asks for the reports that the supervisor lives on, and again when they stop."""

from __future__ import annotations

from flight_replay.mavlink import dialect
from flight_replay.vehicle.link.port import Port
from flight_replay.vehicle.protocol.telemetry import Telemetry

_AGAIN_S = 1.0
_STALE_S = 3.0  # Both in seconds of the vehicle's clock ...
_SHORTEST_S = 0.3  # ... but no shorter than this here, for a link that loses packets.
_STREAMS = {
    dialect.MAV_DATA_STREAM_EXTENDED_STATUS: (4, "SYS_STATUS"),
    dialect.MAV_DATA_STREAM_POSITION: (10, "GLOBAL_POSITION_INT"),
    dialect.MAV_DATA_STREAM_EXTRA1: (4, "ATTITUDE"),
    dialect.MAV_DATA_STREAM_EXTRA2: (2, "VFR_HUD"),
    dialect.MAV_DATA_STREAM_EXTRA3: (2, "EKF_STATUS_REPORT"),
}
"""Reports per second of the vehicle's time (the path flown is measured by its positions), and the
message by which each stream is known to flow."""


class Streams:
    """Keeps the reports coming: a request may get lost, and a reboot forgets them all."""

    def __init__(self, port: Port, telemetry: Telemetry) -> None:
        """Ask over ``port`` for what ``telemetry`` hears."""
        self._port, self._telemetry = port, telemetry
        self._asked_s = float("-inf")

    def keep(self, speedup: float) -> None:
        """Ask if what was asked for does not come; ``speedup`` is how fast the vehicle's clock runs."""
        now_s = self._port.now_s()
        if now_s - self._asked_s < max(_AGAIN_S / speedup, _SHORTEST_S):
            return
        self._asked_s = now_s
        for stream, (rate_hz, sign) in _STREAMS.items():
            if now_s - self._telemetry.heard_s.get(sign, float("-inf")) < max(
                _STALE_S / speedup, _SHORTEST_S
            ):
                continue
            self._port.send(
                dialect.MAVLink_request_data_stream_message(
                    self._port.system, self._port.component, stream, rate_hz, 1
                )
            )
