"""Network addresses as MAVLink tools write them, ``udpin:127.0.0.1:14550``, for all options that take one.

``udpin:`` and ``tcpin:`` listen, ``udpout:`` sends first. ``udp:`` is ``udpin:`` in every option, as in
pymavlink, DroneKit and MAVProxy's ``--master``. ``tcp:`` connects; the simulator listens there.
"""

from __future__ import annotations

import ipaddress
from collections.abc import Mapping
from dataclasses import dataclass, replace

from flight_replay.exceptions import SimulatorError

KINDS: Mapping[str, str] = {
    "udp": "udpin",
    "udpin": "udpin",
    "udpout": "udpout",
    "tcp": "tcp",
    "tcpin": "tcpin",
}
_LARGEST_PORT, _MOST_DIGITS = 65535, 5


@dataclass(frozen=True, slots=True)
class NetworkAddress:
    """One of the values of ``KINDS``; a host, without brackets, empty if none; a port from 0 to 65535."""

    kind: str
    host: str
    port: int

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{self.kind}:{host}:{self.port}"

    @property
    def is_loopback(self) -> bool:
        """Whether only programs of this machine reach it."""
        if self.host.lower() == "localhost":
            return True
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return False

    @property
    def is_unspecified(self) -> bool:
        """Whether it is all addresses of a machine."""
        try:
            return ipaddress.ip_address(self.host).is_unspecified
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
    return NetworkAddress(KINDS[kind.lower()], host.removeprefix("[").removesuffix("]"), int(digits))


def is_serial_port(connection_string: str) -> bool:
    """Whether what a vehicle is connected by is a serial port: all that is not written as an address.

    A port by its path may have colons, as in ``/dev/serial/by-path``.
    """
    kind = connection_string.partition(":")[0].lower()
    is_bare = parse_network_address(f"udpin:{connection_string}") is not None and "/" not in kind
    return kind not in KINDS and not is_bare


def parse_address(text: str) -> NetworkAddress:
    """Parse an address of the simulator: ``tcp`` listens.

    Raises:
        SimulatorError: if it is not ``tcp:``, ``udpin:`` or ``udpout:``, a host and a port.
    """
    named = parse_network_address(text)
    if named is None or not named.host:
        raise SimulatorError(
            f"'{text}' is not a valid address; use tcp:127.0.0.1:5760, udpin:127.0.0.1:14550 or "
            "udpout:127.0.0.1:14550"
        )
    return replace(named, kind="tcp") if named.kind == "tcpin" else named
