"""Looking up bytes and flags in long arrays, many at a time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Bytes, Flags, Indices

FLAGS_AT_ONCE = 64


def rows_at(data: Bytes, starts: Indices, length: int) -> Bytes:
    """The ``length`` bytes from each index (n,) on, shape (n, length)."""
    anywhere: NDArray[np.void] = np.ndarray((len(data) - length + 1,), f"V{length}", data, strides=(1,))
    return anywhere[starts].view(np.uint8).reshape(-1, length)


def true_indices(flags: Flags) -> Indices:
    """Where flags (n,) are true, n being a multiple of ``FLAGS_AT_ONCE``; fast where few are.

    Looks for 64 flags of which one is true, then for eight of these, and then for the true ones: in
    the sparse flags themselves, ``nonzero`` would branch, and mispredict, for each that is true.
    """
    eights = flags.view(np.uint64)
    sixty_fours = (eights != 0).view(np.uint64)
    index: Indices = (sixty_fours != 0).nonzero()[0]
    for words in sixty_fours, eights:
        inner = words.take(index).view(np.bool_).nonzero()[0]
        index = index.take(inner >> 3)
        index <<= 3
        inner &= 7
        index += inner
    return index
