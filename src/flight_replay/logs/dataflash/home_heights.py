"""Heights above home, which a vehicle sets anew with each arming."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats, Indices, Integers
from flight_replay.logs.dataflash.message_rows import Offsets


def heights_above_home_m(
    amsl_m: Floats, above_home_m: Floats, section: Integers, armed_first: Indices
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
    if is_told.all():
        return above_home_m, True
    index = np.arange(len(amsl_m))
    home_fix = _of_section(armed_first, section, index)
    heights_m = np.where(is_told, above_home_m, amsl_m - amsl_m[home_fix])
    told = np.flatnonzero(is_told)
    if len(told):
        following = np.minimum(np.searchsorted(told, index), len(told) - 1)
        first = told[following]
        is_ahead = ~is_told & (section[first] == section) & (first > index)
        heights_m[is_ahead] = (amsl_m - (amsl_m - above_home_m)[first])[is_ahead]
    return heights_m, bool(np.isin(section, section[told]).all())


def _of_section(armed_first: Indices, section: Integers, index: Indices) -> Indices:
    """For each fix (n,) the first fix of its flight, else that of the next or of the section."""
    section_first = np.searchsorted(section, section)
    if not len(armed_first):
        return section_first
    before = np.searchsorted(armed_first, index, "right") - 1
    behind = armed_first[np.minimum(before + 1, len(armed_first) - 1)]
    home_fix = np.where(section[behind] == section, np.maximum(behind, section_first), section_first)
    last = armed_first[np.maximum(before, 0)]
    return np.where((before >= 0) & (section[last] == section), last, home_fix)


def after_home_was_set(offset: Offsets, section: Integers, homes: Offsets, home_section: Indices) -> Flags:
    """Which positions (n,) are behind the first record in their section that home was set."""
    first = np.searchsorted(home_section, section)
    has_home = first < len(homes)
    first = np.minimum(first, max(len(homes) - 1, 0))
    if not len(homes):
        return has_home
    return np.asarray(has_home & (home_section[first] == section) & (homes[first] < offset))
