"""The stretches of a flight that are farthest off, in words."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats

_MOST_STRETCHES = 3


def worst_stretches(off: Flags, off_m: Floats, time_s: Floats, digits: int) -> str:
    """The stretches in which fixes are off farthest, in order, such as "7 m from 12 to 15 s, 6 m at 20 s".

    Args:
        off: which of the fixes are off (n,).
        off_m: by how much (n,).
        time_s: when they are (n,).
        digits: how many decimals distances have.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], off, [False]])))
    stretches = [
        (float(off_m[begin:end].max()), float(time_s[begin]), float(time_s[end - 1]))
        for begin, end in zip(edges[::2], edges[1::2], strict=True)
    ]
    worst = sorted(sorted(stretches, reverse=True)[:_MOST_STRETCHES], key=lambda stretch: stretch[1])
    told = (f"{most:.{digits}f} m {_when(begin, end)}" for most, begin, end in worst)
    return ", ".join(dict.fromkeys(told))  # Two within a second may look alike.


def _when(begin_s: float, end_s: float) -> str:
    """From when to when, in whole seconds."""
    begin, end = f"{begin_s:.0f}", f"{end_s:.0f}"
    return f"at {begin} s" if begin == end else f"from {begin} to {end} s"
