"""What the FMT records of a DataFlash log say of its other records.

Facts of the format are those of ArduPilot's ``AP_Logger/LogStructure.h``: a record is A3 95, its type,
and a payload whose length and columns an FMT record (type 128, 89 bytes) gave before it was first needed.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flight_replay.exceptions import LogError
from flight_replay.geometry.arrays import Indices

HEADER = b"\xa3\x95"
FMT_TYPE = 128
FMT_LENGTH = 89
LONGEST_RECORD = 255  # its length is given in one byte
_HEADER_LENGTH = 3
_NAME_AT, _FORMAT_AT, _COLUMNS_AT = 5, 9, 25
_MOST_CHANGES = 1 << 14
_PX4_GPS_COLUMN = "GPSTime"

# Each column's letter: its numpy type, and what its values are divided by to get its unit.
_LETTERS = {
    "a": ("(32,)<i2", None),
    "b": ("i1", None),
    "B": ("u1", None),
    "h": ("<i2", None),
    "H": ("<u2", None),
    "i": ("<i4", None),
    "I": ("<u4", None),
    "f": ("<f4", None),
    "g": ("<f2", None),
    "d": ("<f8", None),
    "n": ("S4", None),
    "N": ("S16", None),
    "Z": ("S64", None),
    "c": ("<i2", 100.0),
    "C": ("<u2", 100.0),
    "e": ("<i4", 100.0),
    "E": ("<u4", 100.0),
    "L": ("<i4", 1e7),
    "M": ("u1", None),
    "q": ("<i8", None),
    "Q": ("<u8", None),
}


@dataclass(frozen=True, slots=True, eq=False)
class RecordFormat:
    """A kind of record: its ``length`` with its header, and its columns.

    ``dtype`` has a field for each column, ``divisors`` what a column's values are divided by;
    ``dtype`` is None where the columns do not add up to the length, so that only the length counts.
    """

    length: int
    name: str
    columns: tuple[str, ...]
    dtype: np.dtype[Any] | None
    divisors: dict[str, float]


def record_format(fmt: bytes) -> RecordFormat:
    """What an FMT record (``FMT_LENGTH`` bytes) says."""
    name, letters, columns = (
        fmt[first:end].split(b"\0")[0].decode("ascii", "replace")
        for first, end in ((_NAME_AT, _FORMAT_AT), (_FORMAT_AT, _COLUMNS_AT), (_COLUMNS_AT, FMT_LENGTH))
    )
    names = tuple(column.strip() for column in columns.split(",")) if columns else ()
    dtype = _dtype(names, letters, fmt[4])
    divisors = {
        column: divisor
        for column, letter in zip(names, letters, strict=False)
        if (divisor := _LETTERS.get(letter, ("", None))[1]) is not None
    }
    return RecordFormat(fmt[4], name, names, dtype, divisors)


def _dtype(names: tuple[str, ...], letters: str, length: int) -> np.dtype[Any] | None:
    """A record as a numpy type, None where its parts do not fit together."""
    known = all(letter in _LETTERS for letter in letters)
    if not names or not known or len(names) != len(letters) or len(set(names)) < len(names) or "" in names:
        return None
    types = [np.dtype(_LETTERS[letter][0]) for letter in letters]
    ends = np.cumsum([_HEADER_LENGTH, *(each.itemsize for each in types)]).tolist()
    if ends[-1] != length:
        return None
    layout: Any = {"names": list(names), "formats": types, "offsets": ends[:-1], "itemsize": length}
    dtype: np.dtype[Any] = np.dtype(layout)
    return dtype


class FormatTable:
    """The formats in force at a place of a log, for reading the messages of some names.

    ``lengths`` (256,) are the records' lengths by their type, 0 where unknown; ``is_wanted`` (256,) is 1
    for types of wanted names and for FMT itself.
    """

    def __init__(self, names: Iterable[str], log_name: str) -> None:
        self.lengths: Indices = np.zeros(256, np.intp)
        self.lengths[FMT_TYPE] = FMT_LENGTH
        self.is_wanted: NDArray[np.uint8] = np.zeros(256, np.uint8)
        self.is_wanted[FMT_TYPE] = 1
        self.by_type: dict[int, RecordFormat] = {}
        self._names, self._log_name = frozenset(names), log_name
        self._seen: dict[int, bytes] = {}
        self._changes = 0

    def apply(self, fmt: bytes) -> bool:
        """Take an FMT record; whether it changes what other records mean.

        Raises:
            LogError: It is of a format that only looks alike, or formats change without end.
        """
        kind = fmt[3]
        if kind == FMT_TYPE or self._seen.get(kind) == fmt or fmt[4] <= _HEADER_LENGTH:
            return False
        new, old = record_format(fmt), self.by_type.get(kind)
        if new.dtype is None and old is not None and old.dtype is not None:
            return False  # damaged: no firmware writes such a one
        if new.name == "GPS" and _PX4_GPS_COLUMN in new.columns:
            raise LogError(
                f"{self._log_name} is a log of PX4's old logger (.px4log), which is not read; name a log of "
                "ArduPilot, or one of PX4 as ULog (.ulg)"
            )
        self._changes += 1
        if self._changes > _MOST_CHANGES:
            raise LogError(
                f"{self._log_name} defines its records anew more than {_MOST_CHANGES} times, as no "
                "autopilot does; name another log"
            )
        self._seen[kind] = fmt
        self.by_type = {**self.by_type, kind: new}  # whoever has the old one keeps it
        self.lengths[kind] = new.length
        self.is_wanted[kind] = new.name in self._names and new.dtype is not None
        return True

    @property
    def is_empty(self) -> bool:
        """Whether no record told of any format."""
        return not self.by_type
