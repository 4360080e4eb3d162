"""counted.py: numbers of things in messages."""

import pytest

from flight_replay.writing.counted import counted, counted_of


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


@pytest.mark.parametrize(
    ("part", "whole", "noun", "words"),
    [
        (0, 1, "waypoint", "0 of 1 waypoints"),
        (1, 1, "waypoint", "the only waypoint"),
        (1, 2, "fix", "1 of 2 fixes"),
        (3, 3, "flown fix", "all 3 flown fixes"),
        (0, 0, "log", "0 of 0 logs"),
    ],
)
def test_some_are_told_of_all(part: int, whole: int, noun: str, words: str) -> None:
    """All of them as all, and one of one as the only one."""
    assert counted_of(part, whole, noun) == words
