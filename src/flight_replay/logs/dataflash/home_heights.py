"""Heights above home, which a vehicle sets anew with each arming."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Flags, Floats, Indices, Integers
from flight_replay.logs.dataflash.message_rows import Offsets
from flight_replay.logs.dataflash.row_slices import slices


def heights_above_home_m(
    amsl_m: NDArray[np.float32], above_home_m: NDArray[np.float32], section: Integers, armed_first: Indices
) -> tuple[Floats, bool]:
    """Heights (n,) above home, and whether a home is known for all of them.

    Where the log does not tell, home is at the height of the first fix of the flight, of the next one
    before the first, of the section where nothing tells of a flight. Ahead of the first height that the
    log tells of in a section, home is where it was then.

    Args:
        amsl_m: Heights above mean sea level (n,).
        above_home_m: What the log tells (n,), not a number where it does not.
        section: The section of each fix (n,), not falling.
        armed_first: The first fixes of flights (m,), in order.
    """
    is_told = np.isfinite(above_home_m)
    heights_m = above_home_m.astype(float)
    if is_told.all():
        return heights_m, True
    told = np.flatnonzero(is_told)
    for part in slices(len(amsl_m)):
        index = np.flatnonzero(~is_told[part]) + part.start
        heights_m[index] = amsl_m[index].astype(float) - amsl_m[_of_section(armed_first, section, index)]
        if len(told):
            first = told[np.minimum(np.searchsorted(told, index), len(told) - 1)]
            is_ahead = (section[first] == section[index]) & (first > index)
            index, first = index[is_ahead], first[is_ahead]
            heights_m[index] = amsl_m[index] - (amsl_m[first].astype(float) - above_home_m[first])
    return heights_m, bool(np.isin(section, section[told]).all())


def _of_section(armed_first: Indices, section: Integers, index: Indices) -> Indices:
    """For each fix of an index (m,) the first fix of its flight, else that of the next or of the section."""
    own = section[index]
    section_first = np.searchsorted(section, own)
    if not len(armed_first):
        return section_first
    before = np.searchsorted(armed_first, index, "right") - 1
    behind = armed_first[np.minimum(before + 1, len(armed_first) - 1)]
    home_fix = np.where(section[behind] == own, np.maximum(behind, section_first), section_first)
    last = armed_first[np.maximum(before, 0)]
    return np.where((before >= 0) & (section[last] == own), last, home_fix)


def after_home_was_set(offset: Offsets, section: Integers, homes: Offsets, home_section: Indices) -> Flags:
    """Which positions (n,) are behind the first record in their section that home was set."""
    first = np.searchsorted(home_section, section)
    has_home = first < len(homes)
    first = np.minimum(first, max(len(homes) - 1, 0))
    if not len(homes):
        return has_home
    return np.asarray(has_home & (home_section[first] == section) & (homes[first] < offset))
