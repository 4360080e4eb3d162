"""What the parts of a copter have in common of which copies are made in flight."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from typing_extensions import Self


class SnapshotPart:
    """A part of a copter that can be copied, also where mypyc has compiled it."""

    __slots__ = ()

    # Without one, that of a compiled class calls ``__init__``, which a copy is made without.
    def __new__(cls, *args: object, **kwargs: object) -> Self:  # noqa: D102
        return super().__new__(cls)
