"""Where a log's bytes come from: a file, a compressed file, or standard input."""

from __future__ import annotations

import os
import stat
import sys
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Protocol

from flight_replay.errors import LogError

STANDARD_INPUT = "-"
_GZIP_MARK = b"\x1f\x8b\x08"
_HEAD_LENGTH = 512
_PACKED_STEP = 1 << 16


class Stream(Protocol):
    """Bytes in order; ``read`` returns at most ``size`` of them, and none at the end only."""

    def read(self, size: int) -> bytes:
        """The next bytes."""
        ...


class Source:
    """An open log, plain or packed with gzip.

    ``size`` is the number of stored bytes, 0 where that is not known beforehand; ``position``
    tells how many of them were taken from the stream; ``head`` is what the log begins with.
    """

    def __init__(self, name: str, stored: Stream, size: int = 0, descriptor: int | None = None) -> None:
        self.name = name
        self.size = size
        self.position = 0
        self.head = b""
        while len(self.head) < _HEAD_LENGTH and (more := stored.read(_HEAD_LENGTH - len(self.head))):
            self.head += more
        self._stored = stored
        self._held = self.head
        is_packed = self.head.startswith(_GZIP_MARK)
        self.stream: Stream = _Unpacked(self) if is_packed else self
        self.descriptor = None if is_packed else descriptor

    def read(self, size: int) -> bytes:
        """The next stored bytes."""
        data, self._held = self._held[:size], self._held[size:]
        data = data or self._stored.read(size)
        self.position += len(data)
        return data


class _Unpacked:
    """The contents of gzip members one after another, up to the first fault."""

    def __init__(self, packed: Stream) -> None:
        self._packed = packed
        self._inflate = zlib.decompressobj(wbits=31)
        self._pending = b""
        self._step = _PACKED_STEP  # bytes to unpack at once, halved before a fault until none are left

    def read(self, size: int) -> bytes:
        """The next decompressed bytes; a torn or damaged end reads like an end."""
        while self._step:
            self._pending = self._pending or self._packed.read(_PACKED_STEP)
            is_last = not self._pending
            data = self._unpack(size)
            if data or is_last:
                return data
        return b""

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
def opened(path: Path | str) -> Iterator[Source]:
    """The log at a path, or on standard input for ``-``.

    Raises:
        LogError: It cannot be opened or read, or is a directory.
    """
    try:
        if str(path) == STANDARD_INPUT:
            yield Source("standard input", _standard_input())
            return
        path = Path(path)
        with path.open("rb", buffering=0) as file:
            status = os.fstat(file.fileno())
            size = status.st_size if stat.S_ISREG(status.st_mode) else 0
            at_offsets = size > 0 and hasattr(os, "preadv")  # not on every system
            yield Source(str(path), file, size, file.fileno() if at_offsets else None)
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
    return sys.stdin.buffer


def what_it_is(head: bytes) -> str:
    """What a file without any record looks like, by its first bytes."""
    if not head:
        return "is empty"
    for mark, kind in _KINDS:
        if head.startswith(mark):
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
    (_GZIP_MARK, "is gzip data that holds no MAVLink position, heartbeat or GPS record"),
)
