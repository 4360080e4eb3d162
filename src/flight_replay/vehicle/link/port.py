"""A conversation with one vehicle: send, and wait for what it sends to us.

The protocols (mission, parameters, commands) need no more than the two interfaces here, so tests
give them a port with a clock of its own.
"""

from __future__ import annotations

import queue
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any, Protocol

from flight_replay.mavlink import Message
from flight_replay.vehicle.link.link import Link
from flight_replay.vehicle.link.own_ids import OUR_COMPONENT, OUR_SYSTEM
from flight_replay.vehicle.link.round_trip import RoundTrip


class Inbox(Protocol):
    """Messages of chosen kinds, kept until fetched."""

    def get(self, timeout_s: float) -> Message | None:
        """The oldest message not yet fetched; None if none comes in time."""


class Port(Protocol):
    """One vehicle as a correspondent."""

    system: int
    component: int
    trip: RoundTrip
    """What is known of the link's round-trip time; who asks and gets an answer tells it."""

    def send(self, message: Message) -> None:
        """Send a message."""

    def inbox(self, *kinds: str) -> AbstractContextManager[Inbox]:
        """Collect messages of these kinds from the vehicle to us, from now until the context ends."""

    def now_s(self) -> float:
        """Seconds that never run backwards."""


def is_for_us(message: Message) -> bool:
    """Whether a message is addressed to us, to all of our system, or to nobody.

    Other stations share the link. ArduCopter 3.3 asks for mission items, and MAVLink 1 answers commands,
    without an address.
    """
    system = getattr(message, "target_system", 0)
    component = getattr(message, "target_component", 0)
    return (system, component) in {(OUR_SYSTEM, OUR_COMPONENT), (OUR_SYSTEM, 0), (0, 0)}


class _QueueInbox:
    def __init__(self) -> None:
        self.queue: queue.SimpleQueue[Message] = queue.SimpleQueue()

    def get(self, timeout_s: float) -> Message | None:
        """The oldest message not yet fetched; None if none comes in time."""
        try:
            return self.queue.get(timeout=max(timeout_s, 0.0))
        except queue.Empty:
            return None


class LinkPort:
    """A port over a link, sending through a DroneKit vehicle."""

    def __init__(self, link: Link, drone: Any, system: int, component: int) -> None:
        """``drone`` is the ``dronekit.Vehicle`` through which is sent."""
        self._link, self._drone = link, drone
        self.system, self.component = system, component
        self.trip = RoundTrip()

    def send(self, message: Message) -> None:
        """Send a message."""
        self._drone.send_mavlink(message)

    @contextmanager
    def inbox(self, *kinds: str) -> Iterator[Inbox]:
        """Collect messages of these kinds from the vehicle to us, from now until the context ends."""
        inbox = _QueueInbox()

        def receive(message: Message) -> None:
            source = (message.get_srcSystem(), message.get_srcComponent())
            if message.get_type() in kinds and source == (self.system, self.component) and is_for_us(message):
                inbox.queue.put(message)

        self._link.add_receiver(receive)
        try:
            yield inbox
        finally:
            self._link.remove_receiver(receive)

    def now_s(self) -> float:
        """Seconds that never run backwards."""
        return time.monotonic()
