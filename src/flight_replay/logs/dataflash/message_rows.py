"""The records of one message as columns, whether they were bytes or text."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Floats
from flight_replay.logs.dataflash.record_formats import RecordFormat

Offsets = NDArray[np.int64]


class MessageRows(Protocol):
    """Records of one message, in the order of the log."""

    @property
    def name(self) -> str:
        """The message's name."""
        ...

    @property
    def offset(self) -> Offsets:
        """Where in the log the records are (n,)."""
        ...

    def number(self, column: str) -> Floats | None:
        """A column's values (n,) in its unit; None where it has no such column of numbers."""
        ...

    def text(self, column: str) -> list[bytes] | None:
        """A column's texts, None where it has no such column of text."""
        ...


class PackedRows:
    """Records as a binary log has them."""

    def __init__(self, offset: Offsets, format: RecordFormat, rows: NDArray[Any]) -> None:
        """Begin; ``rows`` (n,) have the format's type."""
        self.name, self.offset, self.columns = format.name, offset, format.columns
        self._divisors, self._rows = format.divisors, rows

    def number(self, column: str) -> Floats | None:
        """See ``MessageRows``."""
        values = self._column(column, "iuf")
        if values is None:
            return None
        divisor = self._divisors.get(column)
        return values.astype(np.float64) if divisor is None else values / divisor

    def text(self, column: str) -> list[bytes] | None:
        """See ``MessageRows``."""
        values = self._column(column, "S")
        return None if values is None else values.tolist()

    def _column(self, column: str, kinds: str) -> NDArray[Any] | None:
        if column not in self.columns:
            return None
        values = self._rows[column]
        return values if values.ndim == 1 and values.dtype.kind in kinds else None
