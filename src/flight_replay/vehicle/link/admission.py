"""Which senders that connect to us may act on the vehicle.

A web page can make a browser post any bytes to a local port, MAVLink frames among them. So a sender's
first bytes must be a MAVLink frame, and nothing of it is forwarded before a ground station's heartbeat.
"""

from __future__ import annotations

from collections.abc import Iterator

from flight_replay.mavlink import dialect, parsed, robust_parser

_MARKERS = (dialect.PROTOCOL_MARKER_V1, dialect.PROTOCOL_MARKER_V2)


class NotMavlinkError(Exception):
    """The sender does not speak MAVLink."""


class Admission:
    """The decision for one sender; ``admitted`` once its heartbeat came, or from the start."""

    def __init__(self, *, admitted: bool = False) -> None:
        self._parser = robust_parser()
        self._began = self.admitted = admitted

    def frames(self, data: bytes) -> Iterator[bytes]:
        """The whole frames that may be forwarded, from the heartbeat on.

        Raises:
            NotMavlinkError: What the sender began with is no MAVLink frame.
        """
        if not self._began and data and data[0] not in _MARKERS:
            raise NotMavlinkError
        self._began = True
        for message in parsed(self._parser, data):
            kind = message.get_type()
            if kind == "BAD_DATA" and not self.admitted:
                raise NotMavlinkError
            if kind == "HEARTBEAT" and message.type == dialect.MAV_TYPE_GCS:
                self.admitted = True
            if self.admitted and kind != "BAD_DATA":
                yield bytes(message.get_msgbuf())
