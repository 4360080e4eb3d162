"""Network addresses as MAVLink tools write them, ``udpin:127.0.0.1:14550``, for all options that take one.

``udpin:`` and ``tcpin:`` listen, ``udpout:`` sends first. What a bare ``udp:`` or ``tcp:`` does follows from
what is named, as in MAVProxy and DroneKit: a vehicle (``--master``) or a ground station (``--out``).
The simulator listens at ``tcp:`` and ``tcpin:``, sends to ``udp:`` and ``udpout:``, and at ``udpin:`` listens
for datagrams and answers the last sender.
"""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass

from flight_replay.exceptions import SimulatorError

KINDS = frozenset({"udp", "udpin", "udpout", "tcp", "tcpin"})
_LARGEST_PORT, _MOST_DIGITS = 65535, 5


@dataclass(frozen=True, slots=True)
class NetworkAddress:
    """One of ``KINDS``; a host, without brackets, empty if none was said; a port from 0 to 65535."""

    kind: str
    host: str
    port: int

    @property
    def is_loopback(self) -> bool:
        """Whether only programs of this machine reach it."""
        if self.host.lower() == "localhost":
            return True
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return False


def parse_network_address(text: str) -> NetworkAddress | None:
    """The address that a text names, its kind in any case; None if it is none."""
    kind, _, rest = text.partition(":")
    host, colon, digits = rest.rpartition(":")
    if kind.lower() not in KINDS or not colon or not (digits.isascii() and digits.isdecimal()):
        return None
    if len(digits) > _MOST_DIGITS or int(digits) > _LARGEST_PORT:
        return None
    return NetworkAddress(kind.lower(), host.removeprefix("[").removesuffix("]"), int(digits))


_TRANSPORTS = {"tcp": "tcp", "tcpin": "tcp", "udp": "udpout", "udpout": "udpout", "udpin": "udpin"}


@dataclass(frozen=True, slots=True)
class Address:
    """An address of the simulator: ``kind`` is "tcp", "udpout" or "udpin"."""

    kind: str
    host: str
    port: int

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{self.kind}:{host}:{self.port}"


def parse_address(text: str) -> Address:
    """Parse an address.

    Raises:
        SimulatorError: if it is not ``tcp:``, ``udp:``, ``udpin:`` or ``udpout:``, a host and a port.
    """
    named = parse_network_address(text)
    if named is None or not named.host:
        raise SimulatorError(
            f"'{text}' is not a valid address; use tcp:127.0.0.1:5760 or udp:127.0.0.1:14550"
        )
    return Address(_TRANSPORTS[named.kind], named.host, named.port)
