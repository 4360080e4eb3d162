"""Copies of a copter in AUTO, each of which flies on by itself."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from types import BuiltinMethodType, MethodType
from typing import Any, Final

from flight_replay.simulator.dynamics.auto_yaw import YawMode
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.flight.copter import Copter
from flight_replay.simulator.mission.local_items import LocalItem
from flight_replay.simulator.navigation.hermite import Ends
from flight_replay.simulator.navigation.path_limits import PathLimits
from flight_replay.simulator.navigation.scurve_ramp import Kinematics

_SHARED: Final = frozenset(
    {float, int, bool, type(None), tuple, Ends, Kinematics, Limits, LocalItem, PathLimits, YawMode}
)
"""What never changes, so that a copy may have it, too. No part is in a tuple."""


def copter_copy(copter: Copter, items: Sequence[LocalItem] | None = None) -> Copter:
    """A copter in the same state; the items of its mission are not copied.

    Args:
        copter: which flies a mission, or has flown one.
        items: for the copy instead of the mission's; those that the copter has begun stay as they were.
    """
    run = copter.mission
    known: dict[int, object] = {}
    if run is not None:
        known[id(run.items)] = run.items if items is None else items
    copied = _copied(copter, known)
    assert isinstance(copied, Copter), "a copy is of the same class"
    return copied


def _copied(value: object, known: dict[int, object]) -> object:
    """A copy of a part, a method of one, or a list or dict of what never changes.

    Args:
        value: what to copy.
        known: by the ids of what was copied, the copies.

    Raises:
        TypeError: it is, or its list begins with, what is neither copied nor shared.
    """
    if type(value) in _SHARED:
        return value
    before = known.get(id(value))
    if before is not None:
        return before
    if isinstance(value, SnapshotPart):
        return _copied_part(value, known)
    if isinstance(value, (MethodType, BuiltinMethodType)):
        return getattr(_copied(value.__self__, known), value.__name__)
    if not isinstance(value, (list, dict)):
        raise TypeError(f"{type(value).__name__}: neither copied with a copter nor shared by its copies")
    # Of many alike one is enough to look at.
    for each in value:
        if type(each) not in _SHARED:
            raise TypeError(f"{type(each).__name__}: in a list or dict it would be shared by copies")
        break
    known[id(value)] = copied = value.copy()
    return copied


def _copied_part(part: SnapshotPart, known: dict[int, object]) -> object:
    kind: Any = type(part)
    copied: object = kind.__new__(kind)
    known[id(part)] = copied
    slots, has_others = _attributes(kind)
    for name in (*slots, *vars(part)) if has_others else slots:
        value = getattr(part, name)
        setattr(copied, name, value if type(value) in _SHARED else _copied(value, known))
    return copied


@cache
def _attributes(kind: type) -> tuple[tuple[str, ...], bool]:
    """The attributes of all of a class's objects, and whether each may have others; none that is compiled."""
    names: dict[str, None] = {}
    for base in kind.__mro__:
        own = vars(base)
        names.update(dict.fromkeys(own.get("__mypyc_attrs__", own.get("__slots__", ()))))
    return tuple(names), kind.__dictoffset__ != 0
