"""The one address that frames of a vehicle are taken from, and commands are sent to.

A system id is no proof: two vehicles may have the same, and send to the same port. The first address is
the vehicle's; another is followed only when that is silent, as after a restart of a router or a radio, and
never once both were heard at the same time. Times are wall-clock seconds that never run backwards.
"""

from __future__ import annotations

from collections import deque
from typing import Any

SILENT_S = 2.0
"""A vehicle that was not heard for so long may have another address: it sends a heartbeat every second."""
BOTH_S = 1.0
"""Two addresses that are heard for so long are two vehicles: late packets are not as late as this."""
_MAX_ADDRESSES = 16
_FRAMES = 64
_COPY_S = 0.9


class VehicleSender:
    """The address of the vehicle; ``rival`` is that of another vehicle with its ids, None without one."""

    def __init__(self) -> None:
        self.address: Any = None
        self.rival: Any = None
        self._heard_s = float("-inf")
        self._earlier: list[Any] = []  # Where it was before, the first address first.
        self._others: dict[Any, tuple[float, float]] = {}  # Since when, and when last, another was heard.
        self._rivals: set[Any] = set()
        self._frames: deque[tuple[bytes, Any, float]] = deque(maxlen=_FRAMES)

    def accepts(self, address: Any, frame: bytes, now_s: float) -> bool:
        """Whether a frame with the vehicle's ids, from ``address``, is the vehicle's."""
        if address in self._rivals:
            return False
        self._forget_copy(address, frame, now_s)
        if self.address is None:
            self.address = address
        elif address != self.address:
            if now_s - self._heard_s <= SILENT_S and address not in self._earlier:
                since_s, last_s = self._others.get(address, (now_s, now_s))
                if address in self._others or len(self._others) < _MAX_ADDRESSES:
                    self._others[address] = (since_s if now_s - last_s <= SILENT_S else now_s, now_s)
                return False
            self._follow(address, now_s)
        self._heard_s = now_s
        self._find_rivals(now_s)
        return True

    def _forget_copy(self, address: Any, frame: bytes, now_s: float) -> None:
        """A frame that comes from two addresses is of one vehicle that is heard by two ways."""
        if self._others or address != self.address:
            for known, sender, known_s in self._frames:
                if known == frame and sender != address and now_s - known_s <= _COPY_S:
                    self._others.pop(address, None)
                    self._others.pop(sender, None)
        self._frames.append((frame, address, now_s))

    def _follow(self, address: Any, now_s: float) -> None:
        """The vehicle's address is another now, or an earlier one again: who was heard first counts."""
        if address in self._earlier:
            del self._earlier[self._earlier.index(address) :]
            self._others = {self.address: (now_s, now_s)}
        else:
            if len(self._earlier) < _MAX_ADDRESSES:
                self._earlier.append(self.address)
            self._others = {}
        self.address = address

    def _find_rivals(self, now_s: float) -> None:
        for address, (since_s, last_s) in list(self._others.items()):
            if now_s - since_s >= BOTH_S and now_s - last_s <= SILENT_S:
                del self._others[address]
                if len(self._rivals) < _MAX_ADDRESSES:
                    self._rivals.add(address)
                    self.rival = address
