"""Numbers, times and the cells of tables as text files write them."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator
from datetime import datetime, timedelta, timezone

_NAN = float("nan")
_TIME = re.compile(
    r"\s*(\d{4})-(\d\d)-(\d\d)[T ](\d\d):(\d\d):(\d\d)(?:[.,](\d{1,9})\d*)?\s*"
    r"(?:[Zz]|([+-])(\d\d):?(\d\d))?\s*",
    re.ASCII,
)


_NO_CHARACTER = "\N{REPLACEMENT CHARACTER}"
"""Python 3.10 reads no table that holds a NUL."""


DELIMITERS = ",;\t"
"""What programs part the cells of a table by; spreadsheets take ; where numbers are written with a comma."""


def header_cells(lines: Iterator[str]) -> tuple[list[str], str]:
    """The names of a table's columns, and its delimiter: the one that the header has most of.

    A first line "sep=," only tells Excel what parts the cells.
    """
    first = next(lines, "")
    header = next(lines, "") if first.startswith("sep=") else first
    delimiter = max(DELIMITERS, key=header.count)
    return [cell.strip() for cell in cells_of(header, delimiter)], delimiter


def cells_of(line: str, delimiter: str) -> list[str]:
    """The cells of a line of a table in CSV, none of an empty one."""
    return next(csv.reader([line.replace("\0", _NO_CHARACTER)], delimiter=delimiter))


def number(text: str | None) -> float:
    """The number that a text stands for, not a number where it stands for none."""
    try:
        value = _NAN if text is None or "_" in text else float(text)
    except ValueError:
        return _NAN
    return value if math.isfinite(value) else _NAN


def unix_time_s(text: str | None) -> float:
    """The Unix time of a date and time in ISO 8601, not a number for anything else; UTC unless it says."""
    match = _TIME.fullmatch(text or "")
    if match is None:
        return _NAN
    year, month, day, hour, minute, second = map(int, match.group(1, 2, 3, 4, 5, 6))
    try:
        start = datetime(year, month, day, hour, minute, tzinfo=timezone.utc)
    except ValueError:
        return _NAN
    fraction, sign, hours, minutes = match.group(7, 8, 9, 10)
    offset_s = timedelta(hours=int(hours or 0), minutes=int(minutes or 0)).total_seconds()
    since_s = start.timestamp() + second - (-offset_s if sign == "-" else offset_s)
    return since_s + (float(f"0.{fraction}") if fraction else 0.0)
