"""A link that outlives its troubles: one thread reads, keeps our heartbeat up and reconnects.

DroneKit's own connection dies with the first silence of 30 s, and prints; this one does neither.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

from flight_replay.logs.tlog.writer import Recorder
from flight_replay.mavlink import Message, dialect
from flight_replay.vehicle.link.own_ids import OUR_COMPONENT, OUR_SYSTEM
from flight_replay.vehicle.link.transport import Transport

_log = logging.getLogger(__name__)

_NAP_S = 0.05
_REOPEN_S = 0.3
_CLOSE_S = 5.0  # More than a connection attempt takes.
_SILENT_S = 6.0  # A vehicle sends a heartbeat every second.
_BEATS_PER_S = 1.25  # Of the vehicle's time: ArduCopter 3.3 lands after 5 s of its time without one.
_LEAST_BEAT_S = 0.01

Receiver = Callable[[Message], None]


class Link:
    """MAVLink over a transport. Receivers run on the link's thread, in the order of the frames."""

    def __init__(
        self, transport: Transport, *, speedup: float = 1.0, recorder: Recorder | None = None
    ) -> None:
        """Take over an open transport; ``speedup`` is how fast the vehicle's clock runs."""
        self._transport = transport
        self._recorder = recorder
        self._receivers: list[Receiver] = []
        self._mav = dialect.MAVLink(None, srcSystem=OUR_SYSTEM, srcComponent=OUR_COMPONENT)
        self._mav.robust_parsing = True
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._broken = False
        self._heard_s = time.monotonic()
        self._mavlink1 = True
        self._thread = threading.Thread(target=self._run, name="flight-replay link", daemon=True)
        self.speedup = speedup

    def start(self) -> None:
        """Begin to read, and to send heartbeats."""
        self._thread.start()

    def add_receiver(self, receiver: Receiver) -> None:
        """Hand every message that comes to ``receiver``, whoever sent it."""
        self._receivers = [*self._receivers, receiver]

    def remove_receiver(self, receiver: Receiver) -> None:
        """Hand ``receiver`` no more messages."""
        self._receivers = [other for other in self._receivers if other != receiver]

    def send(self, message: Message) -> None:
        """Send, in MAVLink 1 until version 2 was heard; on a broken link it is lost like any packet."""
        with self._lock:
            frame = message.pack(self._mav, force_mavlink1=self._mavlink1)
            self._mav.seq = (self._mav.seq + 1) % 256
            self._write(frame)

    def forward(self, frame: bytes) -> None:
        """Send a frame that a ground station on the same link made, as it is."""
        with self._lock:
            self._write(frame)

    def _write(self, frame: bytes) -> None:
        try:
            self._transport.write(frame)
        except OSError as error:
            _log.debug("cannot send a frame: %s", error)
            self._broken = True
            return
        if self._recorder:
            self._recorder.write(frame)

    def close(self) -> None:
        """Stop the thread and close the transport."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(_CLOSE_S)
        self._transport.close()

    def _run(self) -> None:
        beat_s = float("-inf")
        while not self._stop.is_set():
            if self._broken and not self._reopen():
                continue
            every_s = max(1.0 / (_BEATS_PER_S * self.speedup), _LEAST_BEAT_S)
            if time.monotonic() - beat_s >= every_s:
                beat_s = time.monotonic()
                self._send_heartbeat()
            self._receive(min(_NAP_S, every_s))

    def _send_heartbeat(self) -> None:
        self.send(
            dialect.MAVLink_heartbeat_message(
                dialect.MAV_TYPE_GCS, dialect.MAV_AUTOPILOT_INVALID, 0, 0, dialect.MAV_STATE_ACTIVE, 3
            )
        )

    def _reopen(self) -> bool:
        try:
            self._transport.open()
        except OSError as error:
            _log.debug("cannot open the link again: %s", error)
            self._stop.wait(_REOPEN_S)
            return False
        self._broken = False
        self._heard_s = time.monotonic()
        return True

    def _receive(self, timeout_s: float) -> None:
        try:
            data = self._transport.read(timeout_s)
        except OSError as error:
            _log.debug("the link broke: %s", error)
            self._broken = True
            return
        if data:
            self._heard_s = time.monotonic()
        elif self._transport.dies_silently and time.monotonic() - self._heard_s > _SILENT_S:
            _log.debug("nothing was heard for %s s", _SILENT_S)
            self._broken = True
        for message in self._mav.parse_buffer(data) or () if data else ():
            if message.get_type() != "BAD_DATA":
                self._take(message)

    def _take(self, message: Message) -> None:
        frame = bytes(message.get_msgbuf())
        if self._recorder:
            self._recorder.write(frame)
        if frame[0] == dialect.PROTOCOL_MARKER_V2:
            self._mavlink1 = False
        for receiver in self._receivers:
            try:
                receiver(message)
            except Exception:
                # One reader's trouble with one message must not deafen the link in flight.
                _log.exception("cannot handle %s", message.get_type())
