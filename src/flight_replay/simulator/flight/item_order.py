"""The order in which AUTO runs a mission's items, jumps included (AP_Mission.cpp)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from flight_replay.mission.items import FIRST_SEQ
from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.mission.local_items import DO_JUMP, FLOWN, LocalItem

# AP_Mission.cpp gives up after so many items without one to fly to.
_MAX_ITEMS: Final = 255


class ItemOrder(SnapshotPart):
    """The items of a mission, and how often each jump was taken."""

    def __init__(self, items: Sequence[LocalItem]) -> None:
        self.items = items
        self._jumped: dict[int, int] = {}

    def advance(self, seq: int) -> tuple[list[LocalItem], LocalItem | None]:
        """Go on from item ``seq``: items done or skipped on the way, and the next item to fly; counts jumps.

        DO items after a navigation item that is skipped are left out, unless they are the first of
        their group (AP_Mission::advance_current_do_cmd).
        """
        return self._next(seq, self._jumped, flown=True)

    def peek(self, seq: int) -> LocalItem | None:
        """The next navigation item from item ``seq`` on, flown or not, without going there."""
        return self._next(seq, self._jumped.copy(), flown=False)[1]

    def _next(
        self, seq: int, jumped: dict[int, int], *, flown: bool
    ) -> tuple[list[LocalItem], LocalItem | None]:
        passed: list[LocalItem] = []
        complete = False
        for _ in range(_MAX_ITEMS):
            index = seq - FIRST_SEQ
            if not 0 <= index < len(self.items):
                break
            item = self.items[index]
            is_navigation = item.is_navigation
            if item.command in FLOWN if flown else is_navigation:
                return passed, item
            seq += 1
            if is_navigation:
                complete = any(not each.is_navigation for each in passed)
                passed.append(item)
            elif item.command != DO_JUMP:
                passed += [] if complete else [item]
            elif item.params[1] < 0 or jumped.get(item.seq, 0) < item.params[1]:
                jumped[item.seq] = jumped.get(item.seq, 0) + 1
                seq = int(item.params[0])
        return passed, None
