"""A copter in flight as it was, copied as often as is wanted."""

from __future__ import annotations

from collections.abc import Sequence

from flight_replay.simulator.flight.copter import Copter
from flight_replay.simulator.flight.copter_copy import copter_copy
from flight_replay.simulator.mission.local_items import LocalItem


class CopterSnapshot:
    """A copter in AUTO as it was; its copies share the mission's items."""

    def __init__(self, copter: Copter, items: Sequence[LocalItem]) -> None:
        self._copter, self._items = copter_copy(copter, items), items

    def copy(self, items: Sequence[LocalItem] | None = None) -> Copter:
        """A copter in the same state, which flies on by itself, with other items if given."""
        return copter_copy(self._copter, self._items, items)
