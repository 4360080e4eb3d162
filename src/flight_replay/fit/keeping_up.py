"""Where the vehicle cannot keep up with the recording, and by how much, in words."""

from __future__ import annotations

import numpy as np

from flight_replay.fit.forecast import Forecast
from flight_replay.fit.recording import Recording

WORTH_A_WORD_M = 5.0
"""Nearer behind than this is keeping up."""
_MOST_STRETCHES = 3


def where_it_lags(best: Forecast, recording: Recording) -> tuple[str, ...]:
    """A sentence on the stretches in which the vehicle is farthest behind the recording, if any.

    Args:
        best: the predicted flight.
        recording: the fixes that it was compared with.
    """
    behind_m = np.where(best.flown_s > recording.time_s, best.late_m, 0.0)
    lags = np.concatenate([[0], (behind_m > WORTH_A_WORD_M).astype(int), [0]])
    begins, ends = np.flatnonzero(np.diff(lags) == 1), np.flatnonzero(np.diff(lags) == -1)
    stretches = [
        (float(behind_m[begin:end].max()), float(recording.time_s[begin]), float(recording.time_s[end - 1]))
        for begin, end in zip(begins, ends, strict=True)
    ]
    if not stretches:
        return ()
    worst = sorted(sorted(stretches, reverse=True)[:_MOST_STRETCHES], key=lambda stretch: stretch[1])
    told = ", ".join(f"{most:.0f} m from {begin:.0f} to {end:.0f} s" for most, begin, end in worst)
    return (f"The vehicle cannot keep up everywhere: it is expected to be behind by up to {told}.",)
