"""The list of items on board."""

from __future__ import annotations

import pytest

from flight_replay.simulator.mission.store import CAPACITY, MissionStore
from flight_replay.simulator.mission.stored_items import StoredItem

WAYPOINT, TAKEOFF, VTOL_TAKEOFF, DELAY, AUX, SPEED = 16, 22, 84, 93, 218, 178
HOME = StoredItem(WAYPOINT, lat_e7=1)


def holding(*commands: int) -> MissionStore:
    """A store with home and these commands."""
    store = MissionStore(lambda: HOME, lambda count: None)
    for seq, command in enumerate([WAYPOINT, *commands]):
        assert store.write(seq, StoredItem(command))
    return store


def test_home_is_item_0_and_is_not_what_was_written_there() -> None:
    """Whatever is uploaded as item 0, home is read; an empty store has home too, but counts 0."""
    store = holding(SPEED)
    assert (len(store), store.read(0), store.items[0]) == (2, HOME, HOME)
    store.truncate(0)
    assert (len(store), store.read(0), store.items) == (0, HOME, ())
    assert store.read(1) is None


def test_items_are_written_in_place_or_right_behind_the_last() -> None:
    """A gap is refused, and so is what is beyond the capacity; every write is a change."""
    counts: list[int] = []
    store = MissionStore(lambda: HOME, counts.append)
    assert not store.write(1, HOME)
    for seq in range(CAPACITY):
        assert store.write(seq, HOME)
    assert not store.write(CAPACITY, HOME)
    assert store.changes == CAPACITY
    assert store.write(5, StoredItem(SPEED))
    assert store.changes == CAPACITY + 1
    assert counts == list(range(1, CAPACITY + 1))


@pytest.mark.parametrize(
    ("commands", "starts"),
    [
        ((TAKEOFF,), True),
        ((VTOL_TAKEOFF,), True),
        ((SPEED, TAKEOFF), True),
        ((DELAY, AUX, TAKEOFF), True),
        ((WAYPOINT, TAKEOFF), False),
        ((SPEED,), False),
        ((), False),
        ((DELAY,) * 16 + (TAKEOFF,), False),
        ((DELAY,) * 15 + (TAKEOFF,), True),
    ],
)
def test_a_mission_starts_with_a_takeoff_if_nothing_is_flown_before(
    commands: tuple[int, ...], starts: bool
) -> None:
    """Delays are looked past, at most 15 of them, as AP_Mission does."""
    assert holding(*commands).starts_with_takeoff(1) == starts
