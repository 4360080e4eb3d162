"""The order in which AUTO takes a mission's items, jumps included (AP_Mission.cpp)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from flight_replay.mission import FIRST_SEQ
from flight_replay.simulator.auto import DO_JUMP, LocalItem

# AP_Mission.cpp gives up after as many items without one to fly to.
_MOST_STEPS = 255


class MissionWalk:
    """The items of a mission, and how often each jump has been taken."""

    def __init__(self, items: Sequence[LocalItem]) -> None:
        self._items = items
        self._jumped: Counter[int] = Counter()

    def advance(self, seq: int) -> tuple[list[LocalItem], LocalItem | None]:
        """From item ``seq`` on: what to do on the way, and the next item to fly; counts jumps."""
        return self._walk(seq, self._jumped)

    def peek(self, seq: int) -> LocalItem | None:
        """The next item to fly from item ``seq`` on, without going there."""
        return self._walk(seq, self._jumped.copy())[1]

    def _walk(self, seq: int, jumped: Counter[int]) -> tuple[list[LocalItem], LocalItem | None]:
        doing: list[LocalItem] = []
        for _ in range(_MOST_STEPS):
            index = seq - FIRST_SEQ
            if not 0 <= index < len(self._items):
                break
            item = self._items[index]
            if item.is_navigation:
                return doing, item
            seq += 1
            if item.command != DO_JUMP:
                doing.append(item)
            elif item.params[1] < 0 or jumped[item.seq] < item.params[1]:
                jumped[item.seq] += 1
                seq = int(item.params[0])
        return doing, None
