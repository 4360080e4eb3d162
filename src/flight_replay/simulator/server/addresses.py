"""Addresses to listen on or send to, as MAVLink tools write them.

``tcp:HOST:PORT`` and ``tcpin:`` listen, ``udp:`` and ``udpout:`` send to an address, ``udpin:``
listens for datagrams and answers the last sender.
"""

from __future__ import annotations

from dataclasses import dataclass

from flight_replay.exceptions import SimulatorError

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
    transport, _, rest = text.partition(":")
    host, _, port = rest.rpartition(":")
    if transport not in _TRANSPORTS or not host or not port.isdigit() or int(port) > 65535:
        raise SimulatorError(
            f"'{text}' is not a valid address; use tcp:127.0.0.1:5760 or udp:127.0.0.1:14550"
        )
    return Address(_TRANSPORTS[transport], host.strip("[]"), int(port))
