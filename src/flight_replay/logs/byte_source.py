"""Where a log's bytes come from: a file, a compressed file, or standard input."""

from __future__ import annotations

import os
import stat
import sys
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Protocol, cast

from flight_replay.exceptions import LogError

STANDARD_INPUT = "-"
_GZIP_MAGIC = b"\x1f\x8b\x08"
HEAD_LENGTH = 4096
"""A log's kind is found in so many of its first bytes."""
_PIECE_LENGTH = 1 << 20
_PACKED_STEP = 1 << 16

Progress = Callable[[int, int], None]
"""Told the stored bytes read so far, and their number (0 where unknown)."""


class Stream(Protocol):
    """Bytes in order."""

    def readinto(self, buffer: memoryview, /) -> int:
        """Fill a buffer, or its beginning, with the next bytes; returns how many, 0 at the end only."""
        ...


class OpenLog:
    """An open log, plain or packed with gzip.

    ``size`` is the number of stored bytes, 0 where that is not known beforehand; ``position``
    tells how many of them were taken from the stream; ``head`` is what the log begins with, unpacked;
    ``stream`` gives all its bytes, unpacked; ``file`` is the plain file on disk, where it is one.
    """

    def __init__(self, name: str, stored: Stream, size: int = 0, file: Path | None = None) -> None:
        self.name = name
        self.size = size
        counted = _CountedStream(stored)
        self._counted = counted
        magic = _first_bytes(counted, len(_GZIP_MAGIC))
        self.is_packed = magic == _GZIP_MAGIC
        self.file = None if self.is_packed else file
        plain = _Prefixed(magic, counted)
        self._gzip = _GzipStream(plain) if self.is_packed else None
        stream: Stream = self._gzip or plain
        self.head = _first_bytes(stream, HEAD_LENGTH)
        self.stream: Stream = _Prefixed(self.head, stream)

    @property
    def position(self) -> int:
        """How many stored bytes were taken."""
        return self._counted.position

    @property
    def ends_early(self) -> bool:
        """Whether gzip data that was read to its end is damaged there, or cut off."""
        return self._gzip is not None and self._gzip.ends_early


class _CountedStream:
    """A stream that tells how many bytes were taken from it."""

    def __init__(self, stream: Stream) -> None:
        self._stream = stream
        self.position = 0

    def readinto(self, buffer: memoryview, /) -> int:
        got = self._stream.readinto(buffer)
        self.position += got
        return got


class _Prefixed:
    """Bytes that were taken from a stream before, and then the rest of it."""

    def __init__(self, before: bytes, stream: Stream) -> None:
        self._before, self._stream = before, stream

    def readinto(self, buffer: memoryview, /) -> int:
        if not self._before:
            return self._stream.readinto(buffer)
        got = min(len(buffer), len(self._before))
        buffer[:got], self._before = self._before[:got], self._before[got:]
        return got


def _first_bytes(stream: Stream, length: int) -> bytes:
    """So many bytes, fewer where the stream ends before."""
    first, got = bytearray(length), 0
    while got < length and (more := stream.readinto(memoryview(first)[got:])):
        got += more
    return bytes(first[:got])


def contents(log: OpenLog, most_bytes: int, progress: Progress | None) -> bytes:
    """All bytes of a log, unpacked, for formats that are read as a whole.

    Args:
        log: A log of which nothing was read yet.
        most_bytes: How many there may be.
        progress: Told the stored bytes read so far, and their number (0 where unknown).

    Raises:
        LogError: There are more.
    """
    read = bytearray()
    piece = memoryview(bytearray(_PIECE_LENGTH))
    while got := log.stream.readinto(piece):
        read += piece[:got]
        if len(read) > most_bytes:
            raise LogError(f"{log.name} is larger than {most_bytes >> 20} MB; cut it, or name another log")
        if progress:
            progress(log.position, log.size)
    return bytes(read)


class _GzipStream:
    """The contents of gzip members one after another, up to the first fault."""

    def __init__(self, packed: Stream) -> None:
        self._packed = packed
        self._inflate = zlib.decompressobj(wbits=31)
        self._buffer = bytearray(_PACKED_STEP)
        self._pending = b""
        self._step = _PACKED_STEP  # bytes to unpack at once, halved before a fault until none are left
        self._is_within_member = False
        self.ends_early = False

    def readinto(self, buffer: memoryview, /) -> int:
        """The next decompressed bytes; a torn or damaged end reads like an end."""
        while self._step:
            if not self._pending:
                self._pending = bytes(self._buffer[: self._packed.readinto(memoryview(self._buffer))])
            is_last = not self._pending
            data = self._unpack(len(buffer))
            if data or is_last:
                buffer[: len(data)] = data
                self.ends_early = not data and self._is_within_member
                return len(data)
        self.ends_early = self._is_within_member
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
        self._is_within_member = not self._inflate.eof and (self._is_within_member or bool(data))
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
        LogError: It cannot be opened or read, or is a directory or a device.
    """
    try:
        if str(path) == STANDARD_INPUT:
            yield OpenLog("standard input", _standard_input())
            return
        path = Path(path)
        _refuse_device(path)
        with path.open("rb", buffering=0) as file:
            status = os.fstat(file.fileno())
            if stat.S_ISREG(status.st_mode):
                yield OpenLog(str(path), file, status.st_size, path)
            else:
                yield OpenLog(str(path), file)
    except IsADirectoryError:
        raise LogError(f"{path} is a directory; name a log file in it") from None
    except FileNotFoundError:
        raise LogError(f"{path} does not exist; name a recorded flight") from None
    except OSError as error:
        why = error.strerror or error
        raise LogError(f"{path} cannot be read ({why}); name a readable log") from error


def _refuse_device(path: Path) -> None:
    """Refuse what may have no end, or not even let itself be opened; a pipe has an end."""
    mode = path.stat().st_mode
    if stat.S_ISCHR(mode) or stat.S_ISBLK(mode):
        raise LogError(f"{path} is a device; name a log of a flight (--connect names a vehicle's port)")


def _standard_input() -> Stream:
    """The bytes that come in; Python has no such thing where the shell closed it."""
    if sys.stdin is None:
        raise LogError("standard input is closed; send a log to it, or name one")
    with suppress(OSError, AttributeError):  # not every stand-in has a descriptor, nor every system the call
        os.set_blocking(sys.stdin.fileno(), True)  # or a sender's pause may look like the end
    return cast(Stream, sys.stdin.buffer)
