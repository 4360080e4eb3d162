"""How DataFlash logs begin."""

from __future__ import annotations

import re

from flight_replay.logs.dataflash.record_formats import FMT_LENGTH, FMT_TYPE, HEADER

_FMT_HEADER = HEADER + bytes([FMT_TYPE])
_LINKED = 4  # FMT records in a row, more than a MAVLink frame holds that carries a piece of such a log
_DENSE = 512  # bytes, twice the longest record
_TEXT = re.compile(rb"^FMT, ?\d+, ?\d+, ?\w+, ?\w+, ?\w", re.MULTILINE)


def begins_dataflash(head: bytes) -> bool:
    """Whether a log with those first bytes is a binary DataFlash log, possibly with a torn beginning."""
    if head.startswith(_FMT_HEADER):
        return True
    if head.startswith(HEADER) and head.count(HEADER) * _DENSE >= len(head):
        return True
    at = head.find(_FMT_HEADER)
    while at >= 0:
        if all(head.startswith(_FMT_HEADER, at + row * FMT_LENGTH) for row in range(_LINKED)):
            return True
        at = head.find(_FMT_HEADER, at + 1)
    return False


def begins_dataflash_text(head: bytes) -> bool:
    """Whether a log with those first bytes is a DataFlash log as text, which describes its records first."""
    return b"\0" not in head and _TEXT.search(head) is not None
