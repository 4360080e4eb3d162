"""The stretches of a flight that are farthest off, in words."""

import numpy as np

from flight_replay.planning.stretches import worst_stretches


def test_the_worst_three_stretches_are_told_in_order() -> None:
    """Each with its largest distance, and with when it begins and ends, or its one second."""
    off_m = np.array([2.0, 0, 1.0, 0, 0, 3.25, 4.0, 0, 5.0])
    told = worst_stretches(off_m > 0, off_m, np.arange(9.0), 1)
    assert told == "2.0 m at 0 s, 4.0 m from 5 to 6 s, 5.0 m at 8 s"


def test_metres_are_rounded_as_asked_for() -> None:
    """Without decimals, too; where nothing is off there is no stretch."""
    off_m, times_s = np.array([0, 2.25, 1.0]), np.array([0, 10.0, 20.0])
    assert worst_stretches(off_m > 0, off_m, times_s, 0) == "2 m from 10 to 20 s"
    assert worst_stretches(off_m > 9, off_m, times_s, 0) == ""


def test_sides_are_told_apart() -> None:
    """A stretch ends where the other side begins, though all of it is off."""
    off_m = np.array([0.0, 1.0, 2.0, -3.0, -1.0, 0.0, 0.5])
    told = worst_stretches(np.abs(off_m) > 0.6, off_m, np.arange(7.0), 0, (" right", " left"))
    assert told == "2 m right from 1 to 2 s, 3 m left from 3 to 4 s"


def test_stretches_that_are_told_alike_are_told_once() -> None:
    off_m, times_s = np.array([0.51, 0.0, 0.52, 0.0, 0.7]), np.array([115.0, 115.2, 115.4, 115.6, 120.0])
    assert worst_stretches(off_m > 0, off_m, times_s, 1) == "0.5 m at 115 s, 0.7 m at 120 s"
