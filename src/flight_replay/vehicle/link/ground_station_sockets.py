"""Sockets to ground stations: data goes to all that are connected, and comes with its sender.

``udpout:HOST:PORT`` sends to a station that listens; ``udpin:HOST:PORT`` (or ``udp:``) listens for
stations; ``tcp:HOST:PORT`` connects to a station that listens; ``tcpin:HOST:PORT`` accepts connections.
"""

from __future__ import annotations

import ipaddress
import os
import socket
from collections.abc import Hashable, Sequence
from dataclasses import replace
from typing import Protocol

from flight_replay.exceptions import FlightReplayError
from flight_replay.simulator.server.addresses import NetworkAddress, parse_network_address
from flight_replay.vehicle.link.ground_station_servers import Received, TcpServer, UdpServer
from flight_replay.vehicle.link.transport import TcpClient, Transport, UdpClient


class GroundStationSocket(Protocol):
    """A socket to ground stations, which can be reopened after an ``OSError``."""

    def open(self) -> None:
        """Open, or reopen."""

    listens: bool
    """Whether senders connect to us, and so have to be admitted before they act."""

    def read(self, timeout_s: float) -> Received:
        """Data as soon as some arrives; empty after the timeout. No data of a sender means that it left."""

    def admit(self, source: Hashable) -> None:
        """This sender is a ground station."""

    def drop(self, source: Hashable) -> None:
        """Disconnect this sender."""

    def write(self, frame: bytes) -> None:
        """Send a frame to all that are connected."""

    def close(self) -> None:
        """Close; no effect when closed."""


def socket_for(address: str, *, allow_open: bool = False) -> GroundStationSocket:
    """The socket that a ``--gcs`` address names.

    Args:
        address: as the module says.
        allow_open: whether it may listen on other addresses than loopback.

    Raises:
        FlightReplayError: The address is invalid, or would let other machines in.
    """
    named = parse_network_address(address)
    if named is not None and named.host:
        host_port = named.host, named.port
        if named.kind in _TRANSPORTS and named.port > 0:
            return TransportSocket(_TRANSPORTS[named.kind](host_port))
        if named.kind in _SERVERS:
            if not allow_open and not named.is_loopback:
                raise FlightReplayError(
                    f"{address} lets every machine that reaches it command the vehicle; listen on 127.0.0.1, "
                    f"add --gcs-open if that is meant, or reach a station that listens by {_other_way(named)}"
                )
            return _SERVERS[named.kind](host_port)
    raise FlightReplayError(
        f"invalid ground station {address!r}; write udpout:HOST:PORT, udpin:HOST:PORT, "
        "tcp:HOST:PORT or tcpin:HOST:PORT"
    )


def check_can_listen(address: str, *, allow_open: bool = False) -> None:
    """Refuse a ``--gcs`` address that is to listen where that is impossible.

    Raises:
        FlightReplayError: As ``socket_for``, or another program has the port, or another machine the address.
    """
    station, named = socket_for(address, allow_open=allow_open), parse_network_address(address)
    if not station.listens or named is None:
        return
    try:
        station.open()
    except OSError as error:
        # create_server adds its own words to the system's.
        reason = os.strerror(error.errno) if error.errno and error.errno > 0 else error.strerror or error
        raise FlightReplayError(
            f"cannot listen for ground stations at {address}: {reason}; choose another port, "
            f"or reach a station that listens there by {_other_way(named)}"
        ) from error
    finally:
        station.close()


def _other_way(named: NetworkAddress) -> str:
    """The address of a station that listens where it was asked to listen for stations.

    All addresses of this machine, such as 0.0.0.0, do not tell where the station is.
    """
    host = "HOST" if named.is_unspecified else named.host
    return str(replace(named, kind="udpout" if named.kind == "udpin" else "tcp", host=host))


_SERVERS: dict[str, type[TcpServer] | type[UdpServer]] = {"tcpin": TcpServer, "udpin": UdpServer}
_TRANSPORTS: dict[str, type[UdpClient] | type[TcpClient]] = {
    "udpout": UdpClient,
    "tcp": TcpClient,
}


def check_distinct(connection: str | None, stations: Sequence[str]) -> None:
    """Refuse an address that is used twice, by ``--connect`` or ``--gcs``: frames would go in circles.

    Raises:
        FlightReplayError: One is.
    """
    used: set[tuple[str, str, int]] = set()
    for address in (*([] if connection is None else [connection]), *stations):
        place = _place(address)
        if place in used:
            raise FlightReplayError(f"{address} is used twice; give the ground station another port")
        if place is not None:
            used.add(place)


def _place(address: str) -> tuple[str, str, int] | None:
    """Protocol, host and port of an address, all names of this machine alike; None for a serial port."""
    named = parse_network_address(address) or parse_network_address(f"udpin:{address}")
    if named is None:
        return None
    here = named.host == "" or named.is_loopback or _is_of_this_machine(named.host)
    return named.kind[:3], "this machine" if here else named.host.lower(), named.port


def _is_of_this_machine(host: str) -> bool:
    """Whether a numeric address is this machine's, or stands for all of those: only such can be bound."""
    try:
        family = socket.AF_INET6 if ipaddress.ip_address(host).version == 6 else socket.AF_INET
        with socket.socket(family, socket.SOCK_DGRAM) as probe:
            probe.bind((host, 0))
    except (ValueError, OSError):
        return False
    return True


class TransportSocket:
    """A connection of ours to a station, whose every frame is forwarded."""

    listens = False

    def __init__(self, transport: Transport) -> None:
        self._transport = transport
        self.open, self.write, self.close = transport.open, transport.write, transport.close

    def read(self, timeout_s: float) -> Received:
        """Data that arrived."""
        data = self._transport.read(timeout_s)
        return [(self._transport.sender, data)] if data else []

    def admit(self, source: Hashable) -> None:
        """It is admitted already."""

    def drop(self, source: Hashable) -> None:
        """It is not dropped: the connection is ours."""
