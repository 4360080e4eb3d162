"""The simulator on the network: accepts stations, routes messages, and keeps time.

The only module that connects the autopilot to sockets and to wall-clock time.
"""

from __future__ import annotations

import selectors
import time
from collections.abc import Callable, Sequence

from flight_replay.mavlink import Message
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.flight.copter import STEP_S
from flight_replay.simulator.protocol.channel import LinkChannel, Sender
from flight_replay.simulator.protocol.ground_link import GroundLink
from flight_replay.simulator.server.addresses import NetworkAddress
from flight_replay.simulator.server.links import ClientSocket, ListenSocket

_OWN_COMPONENTS = (0, 1)
_LONGEST_WAIT_S = 0.1
_MIN_SPEEDUP = 0.01
# More behind than this, the simulation does not catch up: it runs slower, but never in bursts.
_MAX_LAG_S = 0.2


class Endpoint:
    """An autopilot with open links; ``run`` serves them until it is told to stop."""

    def __init__(self, autopilot: Autopilot, addresses: Sequence[NetworkAddress]) -> None:
        """Open the links.

        Raises:
            SimulatorError: if one cannot be opened; the others are closed again.
        """
        self.autopilot = autopilot
        self._link = GroundLink(autopilot)
        self._selector = selectors.DefaultSelector()
        self._listeners: list[ListenSocket] = []
        self._stations: dict[LinkChannel, ClientSocket] = {}
        try:
            for address in addresses:
                self._open(address)
        except BaseException:
            self.close()
            raise

    def _open(self, address: NetworkAddress) -> None:
        listener = ListenSocket(address)
        self._listeners.append(listener)
        if address.kind == "tcp":
            self._selector.register(listener.socket, selectors.EVENT_READ, listener)
        else:
            self._accept(listener)

    @property
    def addresses(self) -> tuple[NetworkAddress, ...]:
        """The addresses of the links, with real port numbers."""
        return tuple(listener.address for listener in self._listeners)

    @property
    def stations(self) -> int:
        """Number of connected stations."""
        return len(self._stations)

    def _accept(self, listener: ListenSocket) -> None:
        connection = listener.accept()
        if connection is None:
            return
        channel = self._link.open_channel(
            connection.write, lambda: connection.has_room, number=self._listeners.index(listener)
        )
        self._stations[channel] = connection
        self._selector.register(connection.socket, selectors.EVENT_READ, channel)

    def _disconnect(self, channel: LinkChannel) -> None:
        connection = self._stations.pop(channel)
        self._link.close_channel(channel)
        self._selector.unregister(connection.socket)
        connection.close()

    def run(self, stop: Callable[[], bool], clock: Callable[[], float] = time.monotonic) -> None:
        """Serve until ``stop`` returns True; it is called at least ten times a second."""
        scheduler = StepScheduler(clock())
        while not stop():
            self.exchange(min(scheduler.wait_s(clock()), _LONGEST_WAIT_S))
            if scheduler.wait_s(clock()) > 0:
                continue
            self.step()
            speedup = self.autopilot.parameters["SIM_SPEEDUP"]
            scheduler.stepped(clock(), STEP_S, max(speedup, _MIN_SPEEDUP) if speedup > 0 else 1.0)

    def step(self) -> None:
        """Let a step of vehicle time pass, and send what is due."""
        self._link.step()
        self._flush()

    def exchange(self, timeout_s: float) -> None:
        """Wait for messages, at most ``timeout_s``, and answer them."""
        for key, _ in self._selector.select(timeout_s):
            if isinstance(key.data, ListenSocket):
                self._accept(key.data)
            else:
                self._read(key.data)
        self._flush()

    def _read(self, channel: LinkChannel) -> None:
        for data in self._stations[channel].read():
            for message, sender in channel.receive(data):
                self._route(message, sender, channel)

    def _flush(self) -> None:
        for channel, connection in list(self._stations.items()):
            connection.flush()
            if not connection.is_open:
                self._disconnect(channel)

    def _route(self, message: Message, sender: Sender, origin: LinkChannel) -> None:
        """Send to the vehicle, to the other stations, or both, by target (MAVLink_routing.cpp)."""
        own = int(self.autopilot.parameters["SYSID_THISMAV"]) & 0xFF
        system = getattr(message, "target_system", 0)
        component = getattr(message, "target_component", 0)
        if system == 0 or (system == own and component in _OWN_COMPONENTS):
            self._link.handle(message, sender)
        if system == own:
            return
        for channel in self._stations:
            if channel is not origin and (system in channel.systems or (system == 0 and channel.systems)):
                channel.forward(bytes(message.get_msgbuf()))

    def close(self) -> None:
        """Disconnect all stations and close the ports."""
        for channel in list(self._stations):
            self._disconnect(channel)
        for listener in self._listeners:
            listener.close()
        self._selector.close()


class StepScheduler:
    """When the next step is due; times are seconds of a monotonic clock."""

    def __init__(self, now_s: float) -> None:
        self._next_s = now_s

    def wait_s(self, now_s: float) -> float:
        """Seconds until the next step; 0 if it is due."""
        return max(0.0, self._next_s - now_s)

    def stepped(self, now_s: float, step_s: float, speedup: float) -> None:
        """Note that a step of ``step_s`` vehicle seconds was taken at ``speedup`` times real time."""
        self._next_s += step_s / speedup
        if now_s - self._next_s > _MAX_LAG_S:
            self._next_s = now_s
