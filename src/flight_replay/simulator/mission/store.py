"""The mission on board: a list of stored items after home, which is item 0 and not stored."""

from __future__ import annotations

from collections.abc import Callable

from flight_replay.simulator.mission.local_items import is_navigation
from flight_replay.simulator.mission.stored_items import StoredItem
from flight_replay.simulator.mission.stored_params import TAKEOFF_COMMANDS

CAPACITY = 650
"""Items including home that ArduPilot's SITL and boards with 16 KB hold (StorageManager.cpp)."""

_SKIPPED_BEFORE_TAKEOFF = frozenset({93, 218})  # NAV_DELAY, DO_AUX_FUNCTION (AP_Mission::is_takeoff_next)
_LOOK_AHEAD = 16


class MissionStore:
    """Items by sequence number; ``on_count`` is called with every new number of items, home included.

    ``changes`` counts writes, and ``receiving`` says whether an upload is under way.
    """

    def __init__(self, home: Callable[[], StoredItem], on_count: Callable[[int], None]) -> None:
        self._home = home
        self._on_count = on_count
        self._items: list[StoredItem] = []
        self.changes = 0
        self.receiving = False

    def __len__(self) -> int:
        return len(self._items)

    @property
    def items(self) -> tuple[StoredItem, ...]:
        """Every item including the slot of home at 0."""
        return (self._home(), *self._items[1:]) if self._items else ()

    def read(self, seq: int) -> StoredItem | None:
        """The item of a sequence number; home can always be read."""
        if seq == 0:
            return self._home()
        return self._items[seq] if 0 < seq < len(self._items) else None

    def write(self, seq: int, item: StoredItem) -> bool:
        """Replace an item, or append it right after the last; False beyond that."""
        if seq > len(self._items) or seq >= CAPACITY:
            return False
        if seq < len(self._items):
            self._items[seq] = item
        else:
            self._items.append(item)
            self._on_count(len(self._items))
        self.changes += 1
        return True

    def truncate(self, count: int) -> None:
        """Keep the first ``count`` items."""
        if count < len(self._items):
            del self._items[count:]
            self.changes += 1
            self._on_count(count)

    def next_navigation(self, seq: int) -> int | None:
        """The first navigation item from a sequence number on."""
        for each in range(max(seq, 1), len(self._items)):
            if is_navigation(self._items[each].command):
                return each
        return None

    def starts_with_takeoff(self, seq: int) -> bool:
        """Whether the next navigation item from a sequence number on takes off."""
        for _ in range(_LOOK_AHEAD):
            found = self.next_navigation(seq)
            if found is None:
                return False
            command = self._items[found].command
            if command not in _SKIPPED_BEFORE_TAKEOFF:
                return command in TAKEOFF_COMMANDS
            seq = found + 1
        return False
