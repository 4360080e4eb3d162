"""The first KML file of a ZIP archive (PKWARE APPNOTE.TXT 6.3), unpacked as it comes in.

The archive is read from its begin, by the headers before each file, so that it may come through a pipe
or be cut off. The KML file is unpacked before any of it is read: unpacking takes a tenth of the time of
reading, so what is too large to be a track is refused soon.
"""

from __future__ import annotations

import struct
import zlib
from collections import deque
from collections.abc import Iterable, Iterator

from flight_replay.exceptions import LogError

_HEADER = struct.Struct("<4s5H3L2H")
_MAGIC = b"PK\x03\x04"
_ENCRYPTED, _LENGTH_BEHIND = 0x1, 0x8
_STORED, _DEFLATED = 0, 8
_IN_EXTRA = 0xFFFFFFFF
"""Files of 4 GB and more have their length elsewhere; what is deflated needs none."""
_STEP = 1 << 16
_TIGHTEST = 100
"""Tracks of parked vehicles are packed 60 times tighter at most, what is made to fill memories 1000 times."""
_LOOSE_BYTES = 2 << 20
"""So much may be packed tighter."""
_MOST_BYTES = 64 << 20
"""What is unpacked of one file: 20 hours of a track at 10 Hz."""


def first_kml(pieces: Iterable[bytes], name: str) -> Iterator[bytes]:
    """The bytes of the first file in an archive whose name ends with ".kml".

    Args:
        pieces: The archive's bytes.
        name: Its name, for errors.

    Raises:
        LogError: There is no such file, or it cannot be unpacked.
    """
    stored = _Stored(pieces)
    while (header := stored.take(_HEADER.size)).startswith(_MAGIC) and len(header) == _HEADER.size:
        _, _, flags, method, _, _, _, packed, _, name_length, extra_length = _HEADER.unpack(header)
        entry = stored.take(name_length)
        stored.take(extra_length)
        if flags & _ENCRYPTED or method not in (_STORED, _DEFLATED):
            raise LogError(f"{name} is packed in a way that is not read; unpack it, and name the file in it")
        length = None if flags & _LENGTH_BEHIND or packed == _IN_EXTRA else packed
        if method == _STORED and length is None:
            raise LogError(f"{name} does not say how long its files are; unpack it, and name the file in it")
        is_kml = entry.lower().endswith(b".kml")
        is_plain = method == _STORED or (length is not None and not is_kml)
        content = stored.pieces(length) if is_plain else _inflated(stored, length, name)
        if is_kml:
            yield from deque(_up_to_most(content, name))
            return
        for _ in content if is_plain else _up_to_most(content, name):
            pass
        if flags & _LENGTH_BEHIND:
            stored.skip_descriptor()
    raise LogError(f"{name} is a ZIP archive without a KML file; unpack it, and name the log in it")


def _up_to_most(content: Iterable[bytes], name: str) -> Iterator[bytes]:
    """The pieces of a file.

    Raises:
        LogError: They are more than are unpacked.
    """
    given = 0
    for piece in content:
        given += len(piece)
        if given > _MOST_BYTES:
            raise LogError(
                f"{name} unpacks to more than {_MOST_BYTES >> 20} MB; unpack it, and name the KML file in it"
            )
        yield piece


class _Stored:
    """The archive's bytes, taken in any length; fewer at its end."""

    def __init__(self, pieces: Iterable[bytes]) -> None:
        self._pieces = iter(pieces)
        self._buffer = b""

    def take(self, length: int) -> bytes:
        """The next bytes."""
        while len(self._buffer) < length and (piece := next(self._pieces, b"")):
            self._buffer += piece
        taken, self._buffer = self._buffer[:length], self._buffer[length:]
        return taken

    def some(self) -> bytes:
        """Any number of next bytes, none at the end only."""
        return self.take(len(self._buffer) or 1)

    def give_back(self, data: bytes) -> None:
        """Bytes that were taken, but are not needed."""
        self._buffer = data + self._buffer

    def pieces(self, length: int | None) -> Iterator[bytes]:
        """The next bytes in pieces, None for all that there are."""
        while (length is None or length > 0) and (piece := self.some()):
            if length is not None:
                self.give_back(piece[length:])
                piece = piece[:length]
                length -= len(piece)
            yield piece

    def skip_descriptor(self) -> None:
        """Skip the lengths behind a file, which may have a mark of their own."""
        has_mark = self.take(4) == b"PK\x07\x08"
        self.take(12 if has_mark else 8)


def _inflated(stored: _Stored, length: int | None, name: str) -> Iterator[bytes]:
    """What a file unpacks to; a fault ends it as if it were cut off there."""
    inflate = zlib.decompressobj(wbits=-15)
    before = given = 0
    for piece in stored.pieces(length):
        packed = piece
        while packed and not inflate.eof:
            try:
                data = inflate.decompress(packed, _STEP)
            except zlib.error:
                return
            given += len(data)
            taken = before + len(piece) - len(inflate.unconsumed_tail)
            if given > _LOOSE_BYTES + _TIGHTEST * taken:
                raise LogError(f"{name} unpacks to far more than a track; name a file with just the track")
            yield data
            packed = inflate.unconsumed_tail
        before += len(piece)
        if inflate.eof and length is None:
            stored.give_back(inflate.unused_data)
            return
