"""Where a log's bytes come from: a file, a compressed file, or standard input."""

from __future__ import annotations

import os
import stat
import sys
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Protocol, cast

from flight_replay.errors import LogError

STANDARD_INPUT = "-"
_GZIP_MAGIC = b"\x1f\x8b\x08"
_HEAD_LENGTH = 512
_PACKED_STEP = 1 << 16


class Stream(Protocol):
    """Bytes in order."""

    def readinto(self, buffer: memoryview, /) -> int:
        """Fill a buffer, or its beginning, with the next bytes; returns how many, 0 at the end only."""
        ...


class OpenLog:
    """An open log, plain or packed with gzip.

    ``size`` is the number of stored bytes, 0 where that is not known beforehand; ``position``
    tells how many of them were taken from the stream; ``head`` is what the log begins with;
    ``stream`` gives its bytes, unpacked.
    """

    def __init__(self, name: str, stored: Stream, size: int = 0) -> None:
        self.name = name
        self.size = size
        self.position = 0
        head, length = bytearray(_HEAD_LENGTH), 0
        while length < _HEAD_LENGTH and (got := stored.readinto(memoryview(head)[length:])):
            length += got
        self.head = bytes(head[:length])
        self._stored = stored
        self._unread_head = self.head
        self.stream: Stream = _GzipStream(self) if self.head.startswith(_GZIP_MAGIC) else self

    def readinto(self, buffer: memoryview, /) -> int:
        """The next stored bytes."""
        if self._unread_head:
            got = min(len(buffer), len(self._unread_head))
            buffer[:got], self._unread_head = self._unread_head[:got], self._unread_head[got:]
        else:
            got = self._stored.readinto(buffer)
        self.position += got
        return got


class _GzipStream:
    """The contents of gzip members one after another, up to the first fault."""

    def __init__(self, packed: Stream) -> None:
        self._packed = packed
        self._inflate = zlib.decompressobj(wbits=31)
        self._buffer = bytearray(_PACKED_STEP)
        self._pending = b""
        self._step = _PACKED_STEP  # bytes to unpack at once, halved before a fault until none are left

    def readinto(self, buffer: memoryview, /) -> int:
        """The next decompressed bytes; a torn or damaged end reads like an end."""
        while self._step:
            if not self._pending:
                self._pending = bytes(self._buffer[: self._packed.readinto(memoryview(self._buffer))])
            is_last = not self._pending
            data = self._unpack(len(buffer))
            if data or is_last:
                buffer[: len(data)] = data
                return len(data)
        return 0

    def _unpack(self, size: int) -> bytes:
        """What the next step of pending bytes holds; nothing if there is a fault in it."""
        before, taken = self._inflate.copy(), self._pending[: self._step]
        try:
            data = self._inflate.decompress(taken, size)
        except zlib.error:  # which takes with it what was right before the fault
            self._inflate = before
            self._step //= 2
            return b""
        rest = self._pending[len(taken) :]
        if self._inflate.eof:
            self._pending = self._inflate.unused_data + rest
            self._inflate = zlib.decompressobj(wbits=31)
        else:
            self._pending = self._inflate.unconsumed_tail + rest
        return data


@contextmanager
def open_log(path: Path | str) -> Iterator[OpenLog]:
    """The log at a path, or on standard input for ``-``.

    Raises:
        LogError: It cannot be opened or read, or is a directory.
    """
    try:
        if str(path) == STANDARD_INPUT:
            yield OpenLog("standard input", _standard_input())
            return
        path = Path(path)
        with path.open("rb", buffering=0) as file:
            status = os.fstat(file.fileno())
            yield OpenLog(str(path), file, status.st_size if stat.S_ISREG(status.st_mode) else 0)
    except IsADirectoryError:
        raise LogError(f"{path} is a directory; name a log file in it") from None
    except FileNotFoundError:
        raise LogError(f"{path} does not exist; name a log with --tlog") from None
    except OSError as error:
        why = error.strerror or error
        raise LogError(f"{path} cannot be read ({why}); name a readable log with --tlog") from error


def _standard_input() -> Stream:
    """The bytes that come in; Python has no such thing where the shell closed it."""
    if sys.stdin is None:
        raise LogError("standard input is closed; send a log to it, or name one with --tlog")
    with suppress(OSError, AttributeError):  # not every stand-in has a descriptor, nor every system the call
        os.set_blocking(sys.stdin.fileno(), True)  # or a sender's pause may look like the end
    return cast(Stream, sys.stdin.buffer)


def describe(head: bytes) -> str:
    """What a file without any record is, by its first bytes."""
    if not head:
        return "is empty"
    for magic, kind in _KINDS:
        if head.startswith(magic):
            return kind
    if _is_text(head, "utf-8-sig"):
        return "is text, not a MAVLink log"
    is_half_zeros = head.count(0) > len(head) // 3  # as UTF-16 is but for the alphabets of the East
    if is_half_zeros and (_is_text(head, "utf-16-le") or _is_text(head, "utf-16-be")):
        return _UTF_16
    return _UNKNOWN


def _is_text(head: bytes, encoding: str) -> bool:
    """Whether all but a last, cut character can be read as text."""
    text = head.decode(encoding, "replace")[:-1]
    return "\ufffd" not in text and all(each.isprintable() or each in "\t\r\n\f" for each in text)


_UTF_16 = "is text in UTF-16, not a MAVLink log"
_UNKNOWN = "holds no MAVLink position, heartbeat or GPS record"
_KINDS = (
    (b"version https://git-lfs", "is a git LFS pointer, not the log itself (git lfs pull fetches it)"),
    (b"\xff\xfe", _UTF_16),
    (b"\xfe\xff", _UTF_16),
    (b"\xa3\x95", "is a DataFlash log, not a telemetry log"),
    (b"ULog\x01\x12\x35", "is a PX4 ULog, not a telemetry log"),
    (b"PK\x03\x04", "is a ZIP archive (unpack it first)"),
    (_GZIP_MAGIC, "is gzip data that holds no MAVLink position, heartbeat or GPS record"),
)
