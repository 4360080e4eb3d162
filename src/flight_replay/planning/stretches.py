"""The stretches of a flight that are farthest off, in words."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats

_MOST_STRETCHES = 3


def worst_stretches(
    off: Flags, off_m: Floats, time_s: Floats, digits: int, sides: tuple[str, str] = ("", "")
) -> str:
    """The stretches in which fixes are off farthest, in order, such as "7 m from 12 to 15 s, 6 m at 20 s".

    Args:
        off: which of the fixes are off (n,).
        off_m: by how much (n,), to the one side more than 0, to the other less.
        time_s: when they are (n,).
        digits: how many decimals distances have.
        sides: a word for each of the sides, such as " too high" and " too low"; none where there is one.
    """
    stretches = [
        (most, float(time_s[begin]), float(time_s[end - 1]), side)
        for sign, side in zip((1.0, -1.0), sides, strict=True)
        for begin, end, most in _runs(off, sign * off_m)
    ]
    worst = sorted(sorted(stretches, reverse=True)[:_MOST_STRETCHES], key=lambda stretch: stretch[1])
    told = (f"{most:.{digits}f} m{side} {_when(begin, end)}" for most, begin, end, side in worst)
    return ", ".join(dict.fromkeys(told))  # Two within a second may look alike.


def _runs(off: Flags, off_m: Floats) -> list[tuple[int, int, float]]:
    """The runs of fixes that are off to this side: their first one, the one behind them, the most of them."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], off & (off_m > 0), [False]])))
    runs = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    return [(begin, end, float(off_m[begin:end].max())) for begin, end in runs]


def _when(begin_s: float, end_s: float) -> str:
    """From when to when, in whole seconds."""
    begin, end = f"{begin_s:.0f}", f"{end_s:.0f}"
    return f"at {begin} s" if begin == end else f"from {begin} to {end} s"
