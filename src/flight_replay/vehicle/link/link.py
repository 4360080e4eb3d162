"""A MAVLink connection that reconnects: one thread receives, sends our heartbeat and reopens the transport.

DroneKit's own connection ends after 30 s without data, and prints; this one does neither.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from typing import Any

from flight_replay.logs.tlog.writer import Recorder
from flight_replay.mavlink import Message, dialect, source_of
from flight_replay.vehicle.link.frame_parser import ParserPool
from flight_replay.vehicle.link.link_faults import LinkFaults
from flight_replay.vehicle.link.own_ids import OUR_COMPONENT, OUR_SYSTEM
from flight_replay.vehicle.link.signing import Signing, is_signed, without_signature
from flight_replay.vehicle.link.transport import Transport
from flight_replay.vehicle.link.vehicle_sender import VehicleSender

_log = logging.getLogger(__name__)

_READ_S = 0.05
_REOPEN_S = 0.3
_CLOSE_S = 5.0  # More than a connection attempt takes.
_SILENT_S = 6.0  # A vehicle sends a heartbeat every second.
_HEARTBEAT_HZ = 1.25  # In vehicle time: ArduCopter 3.3 lands after 5 s of its time without a heartbeat.
_MIN_HEARTBEAT_S = 0.01
_MAX_VEHICLES = 16  # Whose addresses are remembered before one of them is followed.

Receiver = Callable[[Message], None]


class Link:
    """MAVLink over a transport. Receivers are called on the link's thread, in the order of the frames."""

    def __init__(
        self,
        transport: Transport,
        *,
        speedup: float = 1.0,
        recorder: Recorder | None = None,
        signing: Signing | None = None,
    ) -> None:
        """Take over an open transport.

        Args:
            transport: The transport, already open.
            speedup: How fast the vehicle's clock runs.
            recorder: Records every frame as it is on the link.
            signing: Signs what is sent; what is received is ignored unless signed with the same key.
        """
        self._transport = transport
        self._signing = signing
        self.received_signed = False
        """Whether a frame with a signature was received."""
        self.ignored = 0
        """How many frames were ignored because of their signature, or because they had none."""
        self._recorder = recorder
        self._receivers: list[tuple[Receiver, bool, bool]] = []
        self.faults = LinkFaults()
        self._mav = dialect.MAVLink(None, srcSystem=OUR_SYSTEM, srcComponent=OUR_COMPONENT)
        self._parsers = ParserPool()
        self._vehicle: tuple[int, int] | None = None
        self._sender = VehicleSender()
        self._senders: dict[tuple[int, int], VehicleSender] = {}
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._broken = False
        self._received_s = time.monotonic()
        self._heartbeat_s = float("-inf")
        self._heard_mavlink2: set[tuple[int, int]] = set()
        self._thread = threading.Thread(target=self._run, name="flight-replay link", daemon=True)
        self.speedup = speedup

    def start(self) -> None:
        """Start to receive, and to send heartbeats."""
        self._thread.start()

    def add_receiver(self, receiver: Receiver, *, of_vehicle: bool = False, needed: bool = False) -> None:
        """Call ``receiver`` with every message received, or with those of the vehicle that is followed.

        Its gimbal's and another vehicle's are not among the latter. The vehicle is not heard while one
        that is ``needed`` fails; what others raise is only noted.
        """
        self._receivers = [*self._receivers, (receiver, of_vehicle, needed)]

    def remove_receiver(self, receiver: Receiver) -> None:
        """Call ``receiver`` no longer."""
        self._receivers = [other for other in self._receivers if other[0] != receiver]

    @property
    def signs(self) -> bool:
        """Whether frames are signed, and only frames that are signed with the same key are received."""
        return self._signing is not None

    def follow(self, system: int, component: int) -> None:
        """Send to where this vehicle's messages come from, and to nobody else; take them from there only."""
        self._sender = self._senders.get((system, component), self._sender)
        self._vehicle = (system, component)

    @property
    def vehicle_sends_mavlink2(self) -> bool:
        """Whether the vehicle that is followed was heard in MAVLink 2; others on the link do not count."""
        return self._vehicle in self._heard_mavlink2

    @property
    def both_senders(self) -> tuple[str, str] | None:
        """The address of the vehicle and of another with the same ids; None unless both are heard."""
        vehicle, rival = self._sender.address, self._sender.rival
        return None if rival is None else (_as_text(vehicle), _as_text(rival))

    def send(self, message: Message) -> None:
        """Send, as MAVLink 1 until the vehicle sends MAVLink 2; on a broken link the message is lost."""
        self._send(message, mavlink1=not self.vehicle_sends_mavlink2)

    def offer_mavlink2(self) -> None:
        """Send a heartbeat as MAVLink 2; a vehicle that understands it may send MAVLink 2 from then on."""
        self._send(_heartbeat(), mavlink1=False)

    def _send(self, message: Message, *, mavlink1: bool) -> None:
        with self._lock:
            frame = message.pack(self._mav, force_mavlink1=mavlink1)
            self._mav.seq = (self._mav.seq + 1) % 256
            self._write(self._signing.sign(frame) if self._signing else frame)

    def forward(self, frame: bytes) -> None:
        """Send a frame of a ground station on the same link: unchanged, or signed if the link is."""
        try:
            with self._lock:
                self._write(self._signing.sign(frame) if self._signing else frame)
        except KeyError:
            _log.debug("dropped a ground station's frame: it cannot be signed, its message is unknown")

    def _write(self, frame: bytes) -> None:
        if self._broken:
            return
        try:
            self._transport.write(frame)
        except Exception as error:
            self._break(error)
            return
        self._record(frame)

    def _record(self, frame: bytes) -> None:
        """Have the recorder write a frame; an error of it must not reach the sender, nor stop the link."""
        if self._recorder:
            try:
                self._recorder.write(frame)
            except Exception as error:
                _log.exception("cannot record a frame")
                self._recorder.problem = self._recorder.problem or f"a frame was not recorded: {error}"

    def close(self) -> None:
        """Stop the thread and close the transport."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(_CLOSE_S)
        self._transport.close()

    def _break(self, error: Exception | str) -> None:
        """Have the transport reopened, whatever it raised: pyserial also raises TypeError."""
        _log.debug("the link broke: %s", error)
        self._broken = True

    def _run(self) -> None:
        while not self._stop.is_set():
            try:
                self._exchange()
            except BaseException as error:
                # This thread is the only way to the vehicle: no error may end it.
                self.faults.note("read the link", error)
                self._stop.wait(_REOPEN_S)

    def _exchange(self) -> None:
        """Reopen a broken link; else send a heartbeat if one is due, and receive."""
        if self._broken and not self._reopen():
            return
        interval_s = max(1.0 / (_HEARTBEAT_HZ * self.speedup), _MIN_HEARTBEAT_S)
        if time.monotonic() - self._heartbeat_s >= interval_s:
            self._heartbeat_s = time.monotonic()
            try:
                self.send(_heartbeat())
            except Exception as error:
                self.faults.note("send a heartbeat", error, unheard=False)
        self._receive(min(_READ_S, interval_s))

    def _reopen(self) -> bool:
        try:
            self._transport.open()
        except Exception as error:
            _log.debug("cannot reopen the link: %s", error)
            self._stop.wait(_REOPEN_S)
            return False
        self._broken = False
        self._received_s = time.monotonic()
        return True

    def _receive(self, timeout_s: float) -> None:
        try:
            data = self._transport.read(timeout_s)
        except Exception as error:
            self._break(error)
            return
        if data:
            self._received_s = time.monotonic()
        elif self._transport.reopen_if_silent and time.monotonic() - self._received_s > _SILENT_S:
            self._break(f"no data for {_SILENT_S} s")
        for message in self._parsers.messages(data, self._transport.sender):
            try:
                self._deliver(message)
            except Exception as error:
                self._note_fault(message, error)

    def _note_fault(self, message: Message, error: BaseException, *, unheard: bool = True) -> None:
        self.faults.note(f"process {message.get_type()}", error, unheard=unheard)

    def _deliver(self, message: Message) -> None:
        frame = bytes(message.get_msgbuf())
        if not self._accepts(message, frame) or not self._is_of_one_vehicle(message, frame):
            return
        self._record(frame)
        source = source_of(message)
        if frame[0] == dialect.PROTOCOL_MARKER_V2 and self._vehicle in (None, source):
            self._heard_mavlink2.add(source)
        received = []
        for receiver, of_vehicle, needed in self._receivers:
            if of_vehicle and source != self._vehicle:
                continue
            try:
                receiver(message)
            except BaseException as error:
                # An error in one receiver must not stop the link in flight.
                self._note_fault(message, error, unheard=needed)
                received += [False] if needed else []
            else:
                received += [True] if needed else []
        if received and all(received):
            self.faults.passed()

    def _is_of_one_vehicle(self, message: Message, frame: bytes) -> bool:
        """Whether a frame is not one of another vehicle with the same ids as the one that is followed."""
        sender, now_s = self._transport.sender, time.monotonic()
        source = source_of(message)
        if self._vehicle is None:
            is_new = source not in self._senders
            if message.get_type() == "HEARTBEAT" and not (is_new and len(self._senders) >= _MAX_VEHICLES):
                self._senders.setdefault(source, VehicleSender()).accepts(sender, frame, now_s)
            return True
        if sender is None or source != self._vehicle:
            return True
        if not self._sender.accepts(sender, frame, now_s):
            return False
        self._transport.send_only_to(sender)
        return True

    def _accepts(self, message: Message, frame: bytes) -> bool:
        """Whether a frame may be heeded; on a signed link, receivers get it without its signature."""
        self.received_signed = self.received_signed or is_signed(frame)
        if self._signing is None:
            return True
        is_known = message.get_msgId() in dialect.mavlink_map
        if not is_known or not self._signing.accepts(frame):
            self.ignored += 1
            return False
        message.get_msgbuf()[:] = without_signature(frame)
        return True


def _heartbeat() -> Message:
    """Ours, of a ground station."""
    return dialect.MAVLink_heartbeat_message(
        dialect.MAV_TYPE_GCS, dialect.MAV_AUTOPILOT_INVALID, 0, 0, dialect.MAV_STATE_ACTIVE, 3
    )


def _as_text(address: Any) -> str:
    """A UDP address, of either version, as people write it."""
    host, port = address[:2]
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
