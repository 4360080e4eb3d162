"""Puts tables of consecutive parts of a log together."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Columns = TypeVar("Columns", bound="DataclassInstance")


class ColumnBuffer(Generic[Columns]):
    """Tables of one kind, a dataclass of arrays (n,), joined as they come.

    The columns are in byte arrays, which grow in place: no record is ever held twice, and no memory is
    left behind in pieces.
    """

    def __init__(self, kind: type[Columns]) -> None:
        self._kind = kind
        self._bytes = {each.name: bytearray() for each in fields(kind)}
        self._dtypes: dict[str, np.dtype[Any]] = {}

    def add(self, part: Columns) -> None:
        """Append the rows of a table."""
        for name in self._bytes:
            column: NDArray[Any] = getattr(part, name)
            self._dtypes[name] = column.dtype
            self._bytes[name] += np.ascontiguousarray(column).view(np.uint8).data

    @property
    def columns(self) -> Columns:
        """All rows, of tables of which there was one at least; none can be added any more."""
        columns = {}
        for name, grown in self._bytes.items():
            dtype = self._dtypes[name]
            columns[name] = np.ndarray((len(grown) // dtype.itemsize,), dtype, grown)
        return self._kind(**columns)
