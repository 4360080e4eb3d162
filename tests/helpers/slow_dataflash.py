"""The plain reader of DataFlash logs that the fast one is held against: it walks every byte offset."""

from __future__ import annotations

from collections.abc import Iterator

HEADER, FMT, FMT_LENGTH = b"\xa3\x95", 128, 89
_SIZES = {
    "a": 64, "b": 1, "B": 1, "h": 2, "H": 2, "i": 4, "I": 4, "f": 4, "g": 2, "d": 8, "n": 4, "N": 16, "Z": 64,
    "c": 2, "C": 2, "e": 4, "E": 4, "L": 4, "M": 1, "q": 8, "Q": 8,
}  # fmt: skip
Record = tuple[int, str, bytes]
"""Offset, message and all bytes of a record."""


def records(data: bytes) -> Iterator[Record]:
    """All records: those that a header, or the end, follows."""
    lengths, names, whole = {FMT: FMT_LENGTH}, {FMT: "FMT"}, {FMT: True}
    at = 0
    while at + 3 <= len(data):
        length = lengths.get(data[at + 2], 0) if data.startswith(HEADER, at) else 0
        end = at + length
        if not length or not (end == len(data) or data.startswith(HEADER, end)):
            at += 1
            continue
        record = data[at:end]
        if record[2] != FMT:
            if whole[record[2]]:
                yield at, names[record[2]], record
        elif record[3] != FMT and record[4] > 3:
            fits = _fits(record)
            if fits or not whole.get(record[3], False):
                lengths[record[3]], whole[record[3]] = record[4], fits
                names[record[3]] = record[5:9].split(b"\0")[0].decode("ascii", "replace")
        at = end


def _fits(fmt: bytes) -> bool:
    """Whether the columns that an FMT record tells add up to its length."""
    letters = fmt[9:25].split(b"\0")[0].decode("ascii", "replace")
    columns = [each.strip() for each in fmt[25:89].split(b"\0")[0].decode("ascii", "replace").split(",")]
    if len(set(columns)) < len(letters) or len(columns) != len(letters) or "" in columns:
        return False
    return all(each in _SIZES for each in letters) and 3 + sum(_SIZES[each] for each in letters) == fmt[4]
