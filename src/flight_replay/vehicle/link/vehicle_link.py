"""A link to one vehicle: messages to it, and its messages to us.

The protocols (mission, parameters, commands) need only the two interfaces here, so that tests can
run them against a simulated link in virtual time.
"""

from __future__ import annotations

import queue
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any, Protocol

from flight_replay.mavlink import Message
from flight_replay.vehicle.link.link import Link
from flight_replay.vehicle.link.link_faults import LinkFaults
from flight_replay.vehicle.link.own_ids import OUR_COMPONENT, OUR_SYSTEM
from flight_replay.vehicle.link.round_trip import RoundTrip


class Inbox(Protocol):
    """Received messages of chosen types, in order."""

    def get(self, timeout_s: float) -> Message | None:
        """The oldest message not yet taken; None if none comes in time."""


class VehicleLink(Protocol):
    """A link to the vehicle with this system and component id."""

    system: int
    component: int
    round_trip: RoundTrip
    """Of pings measured by the link, else by whoever sends a request and receives its answer."""

    def send(self, message: Message) -> None:
        """Send a message."""

    def inbox(self, *types: str) -> AbstractContextManager[Inbox]:
        """Collect the vehicle's messages of these types to us, from now until the context ends."""

    def now_s(self) -> float:
        """Wall-clock seconds that never run backwards."""


def is_for_us(message: Message) -> bool:
    """Whether a message is addressed to us, to all of our system, or to nobody.

    Other stations share the link. ArduCopter 3.3 requests mission items, and MAVLink 1 answers
    commands, without an address.
    """
    system = getattr(message, "target_system", 0)
    component = getattr(message, "target_component", 0)
    return (system, component) in {(OUR_SYSTEM, OUR_COMPONENT), (OUR_SYSTEM, 0), (0, 0)}


class _QueueInbox:
    def __init__(self, faults: LinkFaults) -> None:
        self.queue: queue.SimpleQueue[Message] = queue.SimpleQueue()
        self._faults = faults

    def get(self, timeout_s: float) -> Message | None:
        """The oldest message not yet taken; None if none comes in time.

        Raises:
            LinkFaultError: None can come.
        """
        try:
            return self.queue.get(timeout=max(timeout_s, 0.0))
        except queue.Empty:
            self._faults.check()
            return None


class DroneKitLink:
    """A ``VehicleLink`` that sends through a DroneKit vehicle and receives from its link."""

    def __init__(self, link: Link, drone: Any, system: int, component: int) -> None:
        """``drone`` is the ``dronekit.Vehicle``."""
        self._link, self._drone = link, drone
        self.system, self.component = system, component
        self.round_trip = RoundTrip()
        link.add_receiver(self._measure, of_vehicle=True)

    def _measure(self, message: Message) -> None:
        if message.get_type() == "TIMESYNC":
            self.round_trip.answered(message, self.now_s())

    def send(self, message: Message) -> None:
        """Send a message."""
        self._drone.send_mavlink(message)

    @contextmanager
    def inbox(self, *types: str) -> Iterator[Inbox]:
        """Collect the vehicle's messages of these types to us, from now until the context ends."""
        inbox = _QueueInbox(self._link.faults)

        def receive(message: Message) -> None:
            if message.get_type() in types and is_for_us(message):
                inbox.queue.put(message)

        self._link.add_receiver(receive, of_vehicle=True)
        try:
            yield inbox
        finally:
            self._link.remove_receiver(receive)

    def now_s(self) -> float:
        """Wall-clock seconds that never run backwards."""
        return time.monotonic()
