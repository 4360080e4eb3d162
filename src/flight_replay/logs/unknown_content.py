"""What a file is that holds no flight, told by its first bytes."""

from __future__ import annotations

import re

from flight_replay.logs.tracks.byte_pieces import text_of


def describe(head: bytes, *, is_packed: bool) -> str:
    """What a file without any record is, by its first bytes, for a sentence that begins with its name."""
    if is_packed:
        return "is gzip data that holds no flight"
    if not head:
        return "is empty"
    for magic, kind in _KINDS:
        if head.startswith(magic):
            return kind
    if _is_text(head, "utf-8-sig"):
        return _text_kind(head)
    is_half_zeros = head.count(0) > len(head) // 3  # as UTF-16 is but for the alphabets of the East
    if is_half_zeros and (_is_text(head, "utf-16-le") or _is_text(head, "utf-16-be")):
        return _UTF_16
    return _UNKNOWN


def _is_text(head: bytes, encoding: str) -> bool:
    """Whether all but a last, cut character can be read as text."""
    text = head.decode(encoding, "replace")[:-1]
    return "\ufffd" not in text and all(each.isprintable() or each in "\t\r\n\f" for each in text)


def _text_kind(head: bytes) -> str:
    if _PLAN.search(head):
        return _MISSION
    return _OTHER_TABLE if _is_table_of_positions(head) else "is text that holds no flight"


def _is_table_of_positions(head: bytes) -> bool:
    """Whether the first line names a column of latitudes among others."""
    first = next(iter(text_of(head).splitlines()), "")
    cells = re.split("[,;\t]", first)
    return len(cells) > 1 and any(map(_LATITUDE.search, cells))


_OTHER_TABLE = (
    'is a table without the columns that can be read: kind (the first, "track" in each row), time_s, '
    "lat_deg, lon_deg and alt_m, as --save FILE.csv writes them, or those of AirData or DJI CsvView"
)
_LATITUDE = re.compile("latitude|(?<![a-z])lat(?![a-z])", re.IGNORECASE)
_MISSION = "is a mission, not a recorded flight"
_PLAN = re.compile(rb'"fileType"\s*:\s*"Plan"')
_UTF_16 = "is text in UTF-16, not a log"
_UNKNOWN = "holds no MAVLink position, heartbeat or GPS record, and is no other log that can be read"
_KINDS = (
    (b"version https://git-lfs", "is a git LFS pointer, not the log itself (git lfs pull fetches it)"),
    (b"\xff\xfe", _UTF_16),
    (b"\xfe\xff", _UTF_16),
    (b"\xfd7zXZ\0", "is packed with xz: unpack it first"),
    (b"BZh", "is packed with bzip2: unpack it first"),
    (b"\x28\xb5\x2f\xfd", "is packed with zstd: unpack it first"),
    (b"7z\xbc\xaf\x27\x1c", "is a 7z archive: unpack it first"),
    (b"Rar!\x1a\x07", "is a RAR archive: unpack it first"),
    (b"QGC WPL", _MISSION),
)
