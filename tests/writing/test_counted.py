"""counted.py: numbers of things in messages."""

import pytest

from flight_replay.writing.counted import counted


@pytest.mark.parametrize(
    ("count", "noun", "words"),
    [
        (0, "fix", "0 fixes"),
        (1, "fix", "1 fix"),
        (2, "recorded fix", "2 recorded fixes"),
        (1, "waypoint", "1 waypoint"),
        (100, "waypoint", "100 waypoints"),
    ],
)
def test_one_of_a_kind_is_told_as_one(count: int, noun: str, words: str) -> None:
    """None are told as many."""
    assert counted(count, noun) == words
