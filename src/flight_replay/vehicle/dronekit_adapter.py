"""The adapter to DroneKit, and the only module that imports it.

DroneKit 2.9.2 is unmaintained: it needs ``past`` (from ``future``) without declaring it and a name
that was removed from ``collections`` in Python 3.10, and its own connection ends after 30 s without
data. So its ``Vehicle`` gets a connection of ours, with the messages of one vehicle only.
"""

from __future__ import annotations

import collections
import collections.abc
import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from flight_replay.exceptions import VehicleError
from flight_replay.mavlink import Message, dialect
from flight_replay.vehicle.link.link import Link
from flight_replay.vehicle.link.own_ids import OUR_COMPONENT, OUR_SYSTEM

_log = logging.getLogger(__name__)
_BROADCAST = 0


@contextmanager
def _root_logger_unchanged() -> Iterator[None]:
    """Remove the handlers that DroneKit adds to the root logger, for the whole program."""
    root = logging.getLogger()
    before = list(root.handlers)
    try:
        yield
    finally:
        for handler in set(root.handlers) - set(before):
            root.removeHandler(handler)


@contextmanager
def _mutable_mapping_in_collections() -> Iterator[None]:
    """``collections.MutableMapping``, which Python 3.10 removed, while DroneKit is imported."""
    missing = not hasattr(collections, "MutableMapping")
    if missing:
        vars(collections)["MutableMapping"] = collections.abc.MutableMapping
    try:
        yield
    finally:
        if missing:
            del vars(collections)["MutableMapping"]


def import_dronekit() -> Any:
    """The DroneKit module, on newer Pythons than it supports too.

    Raises:
        VehicleError: DroneKit, or a package that it needs, is not installed.
    """
    try:
        with _mutable_mapping_in_collections():
            import dronekit
    except ImportError as error:
        raise VehicleError(
            f"DroneKit cannot be imported ({error}); install it with: pip install dronekit future"
        ) from error
    # Status texts become events; without a handler Python would print them too.
    autopilot = logging.getLogger("autopilot")
    autopilot.addHandler(logging.NullHandler())
    autopilot.propagate = False
    return dronekit


class _LinkSender(dialect.MAVLink):  # type: ignore[misc]
    """Sends DroneKit's messages over our link, addressed to the vehicle."""

    def __init__(self, link: Link, system: int) -> None:
        super().__init__(None, srcSystem=OUR_SYSTEM, srcComponent=OUR_COMPONENT)
        self._link, self._system = link, system

    def send(self, message: Message, force_mavlink1: bool = False) -> None:
        """Send; a message without an address goes to the vehicle."""
        if getattr(message, "target_system", None) == _BROADCAST:
            message.target_system = self._system
        self._link.send(message)


class DroneKitConnection:
    """The interface that DroneKit's ``Vehicle`` expects of a connection, over our link."""

    def __init__(self, link: Link, system: int) -> None:
        from pymavlink import mavutil

        self._listeners: list[Callable[[Any, Message], None]] = []
        self.target_system = system
        # Without a file descriptor: nothing is read or written through it.
        self.master = mavutil.mavfile(None, "flight-replay", source_system=OUR_SYSTEM, input=False)
        self.master.target_system = system
        self.master.mav = _LinkSender(link, system)

    def forward_message(self, listener: Callable[[Any, Message], None]) -> None:
        """DroneKit's decorator for functions that receive messages."""
        self._listeners.append(listener)

    def forward_loop(self, listener: Callable[[Any], None]) -> None:
        """DroneKit's decorator for its main loop (heartbeats, timeouts, parameters), which is not run."""

    def fix_targets(self, message: Message) -> None:
        """Address a message to the vehicle."""
        message.target_system = self.target_system

    def deliver(self, message: Message) -> None:
        """Pass a message of the vehicle to DroneKit."""
        for listener in self._listeners:
            try:
                listener(self, message)
            except Exception as error:
                # DroneKit raises on modes and severities newer than itself.
                _log.debug("DroneKit cannot process %s: %s", message.get_type(), error)

    def close(self) -> None:
        """No effect: whoever opened the link closes it."""


def dronekit_vehicle(link: Link, system: int) -> Any:
    """A ``dronekit.Vehicle`` that receives the messages of the vehicle that the link follows."""
    dronekit = import_dronekit()
    connection = DroneKitConnection(link, system)
    with _root_logger_unchanged():
        vehicle = dronekit.Vehicle(connection)
    link.add_receiver(connection.deliver, of_vehicle=True)
    return vehicle
