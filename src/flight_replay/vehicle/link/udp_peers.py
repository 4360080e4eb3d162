"""Whom a listening UDP socket sends to: bounded, expiring, and only the vehicle once that is known.

The link's thread changes it; other threads read ``addresses``, a tuple that is replaced as a whole.
"""

from __future__ import annotations

from typing import Any

MAX_PEERS = 16
EXPIRY_S = 10.0
"""A peer that has sent nothing for so long is forgotten; vehicles send a heartbeat every second."""


class UdpPeers:
    """The addresses that datagrams came from; times are wall-clock seconds that never run backwards."""

    def __init__(self) -> None:
        self._received_s: dict[Any, float] = {}
        self._vehicle: Any = None
        self.addresses: tuple[Any, ...] = ()
        """Whom to send to."""

    def received(self, address: Any, now_s: float) -> None:
        """A datagram came from ``address``."""
        if address == self._vehicle:
            return
        self._received_s.pop(address, None)
        self._received_s[address] = now_s
        while len(self._received_s) > MAX_PEERS or self._oldest_s < now_s - EXPIRY_S:
            del self._received_s[next(iter(self._received_s))]
        if self._vehicle is None:
            self.addresses = tuple(self._received_s)

    @property
    def _oldest_s(self) -> float:
        return next(iter(self._received_s.values()))

    def send_only_to(self, address: Any) -> None:
        """``address`` is the vehicle's: nobody else is sent anything any more."""
        self._vehicle = address
        self.addresses = (address,)
