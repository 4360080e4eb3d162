"""The wall around DroneKit, and the only module that imports it.

DroneKit 2.9.2 is unmaintained: it needs ``past`` (from ``future``) without saying so and a name
that left ``collections`` in Python 3.10, and its own connection gives up after one long silence.
So its ``Vehicle`` gets a connection of ours, which hears nothing but the vehicle that is flown.
"""

from __future__ import annotations

import collections
import collections.abc
import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from flight_replay.errors import VehicleError
from flight_replay.mavlink import Message, dialect
from flight_replay.vehicle.link.link import Link
from flight_replay.vehicle.link.own_ids import OUR_COMPONENT, OUR_SYSTEM

_log = logging.getLogger(__name__)
_ANY = 0


@contextmanager
def _same_logging() -> Iterator[None]:
    """The root logger as it was: DroneKit configures it for the whole program."""
    root = logging.getLogger()
    before = list(root.handlers)
    try:
        yield
    finally:
        for handler in set(root.handlers) - set(before):
            root.removeHandler(handler)


@contextmanager
def _old_collections() -> Iterator[None]:
    """``collections.MutableMapping``, which Python 3.10 took away, for as long as DroneKit is imported."""
    missing = not hasattr(collections, "MutableMapping")
    if missing:
        vars(collections)["MutableMapping"] = collections.abc.MutableMapping
    try:
        yield
    finally:
        if missing:
            del vars(collections)["MutableMapping"]


def import_dronekit() -> Any:
    """The DroneKit module, on Pythons that it does not know of too.

    Raises:
        VehicleError: DroneKit, or something that it needs, is not installed.
    """
    try:
        with _old_collections():
            import dronekit
    except ImportError as error:
        raise VehicleError(
            f"DroneKit cannot be imported ({error}); install it with: pip install dronekit future"
        ) from error
    # What the vehicle says is told as events; without a handler Python would print it too.
    autopilot = logging.getLogger("autopilot")
    autopilot.addHandler(logging.NullHandler())
    autopilot.propagate = False
    return dronekit


class _Outbox(dialect.MAVLink):  # type: ignore[misc]
    """DroneKit's way out: messages leave through our link, addressed to the vehicle."""

    def __init__(self, link: Link, system: int) -> None:
        super().__init__(None, srcSystem=OUR_SYSTEM, srcComponent=OUR_COMPONENT)
        self._link, self._system = link, system

    def send(self, message: Message, force_mavlink1: bool = False) -> None:
        """Send; a message without an address goes to the vehicle."""
        if getattr(message, "target_system", None) == _ANY:
            message.target_system = self._system
        self._link.send(message)


class Connection:
    """What DroneKit's ``Vehicle`` asks of a connection, on a link that is ours."""

    def __init__(self, link: Link, system: int, component: int) -> None:
        from pymavlink import mavutil

        self._system, self._component = system, component
        self._listeners: list[Callable[[Any, Message], None]] = []
        self.target_system = system
        # A file descriptor of None: nothing is ever read or written through it.
        self.master = mavutil.mavfile(None, "flight-replay", source_system=OUR_SYSTEM, input=False)
        self.master.target_system = system
        self.master.mav = _Outbox(link, system)

    def forward_message(self, listener: Callable[[Any, Message], None]) -> None:
        """DroneKit's decorator for readers of messages."""
        self._listeners.append(listener)

    def forward_loop(self, listener: Callable[[Any], None]) -> None:
        """DroneKit's decorator for chores: heartbeats, time limits, all parameters. Ours are other ones."""

    def fix_targets(self, message: Message) -> None:
        """Address a message to the vehicle."""
        message.target_system = self.target_system

    def deliver(self, message: Message) -> None:
        """Hand DroneKit a message, if the vehicle itself sent it and not its gimbal or a neighbour."""
        if (message.get_srcSystem(), message.get_srcComponent()) != (self._system, self._component):
            return
        for listener in self._listeners:
            try:
                listener(self, message)
            except Exception as error:
                # DroneKit stumbles over modes and severities newer than itself.
                _log.debug("DroneKit cannot handle %s: %s", message.get_type(), error)

    def close(self) -> None:
        """The link is closed by whoever opened it."""


def dronekit_vehicle(link: Link, system: int, component: int) -> Any:
    """A ``dronekit.Vehicle`` on ``link`` that follows what ``system``/``component`` sends from now on."""
    dronekit = import_dronekit()
    connection = Connection(link, system, component)
    with _same_logging():
        vehicle = dronekit.Vehicle(connection)
    link.add_receiver(connection.deliver)
    return vehicle
