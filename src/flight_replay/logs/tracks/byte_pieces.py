"""A log's bytes piece by piece, and its text line by line, for formats that are read as they come in."""

from __future__ import annotations

import codecs
import io
from collections.abc import Iterator

from flight_replay.exceptions import LogError
from flight_replay.logs.byte_source import OpenLog, Progress

_PIECE_LENGTH = 1 << 16
_LONGEST_LINE = 1 << 16
_MOST_BYTES = 256 << 20


class LogPieces:
    """The bytes of a log of which nothing was read yet; ``count`` is how many were given so far."""

    def __init__(self, log: OpenLog, progress: Progress | None = None) -> None:
        self._log, self._progress = log, progress
        self.count = 0

    def __iter__(self) -> Iterator[bytes]:
        piece = memoryview(bytearray(_PIECE_LENGTH))
        while got := self._log.stream.readinto(piece):
            self.count += got
            if self._progress:
                self._progress(self._log.position, self._log.size)
            yield bytes(piece[:got])

    def lines(self) -> Iterator[str]:
        """The lines of the text, however they end, without their ends; what cannot be decoded is replaced.

        Raises:
            LogError: There is no end of a line, or of the text.
        """
        text = codecs.getincrementaldecoder(encoding_of(self._log.head))("replace")
        decoder = io.IncrementalNewlineDecoder(text, translate=True)
        rest = ""
        for piece in self:
            *lines, rest = (rest + decoder.decode(piece)).split("\n")
            yield from lines
            if len(rest) > _LONGEST_LINE or self.count > _MOST_BYTES:
                what = "a line" if len(rest) > _LONGEST_LINE else "a table"
                raise LogError(f"{self._log.name} has {what} that is too long; name another log")
        if last := rest + decoder.decode(b"", final=True):
            yield last


def encoding_of(head: bytes) -> str:
    """The encoding of a text by its first bytes; Latin-1 where they are no UTF-8."""
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    if head[1:2] == b"\0" or head[3:4] == b"\0":
        return "utf-16-le"
    if head[:1] == b"\0":
        return "utf-16-be"
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8-sig"


def text_of(head: bytes) -> str:
    """The first characters of a text."""
    return codecs.getincrementaldecoder(encoding_of(head))("replace").decode(head)
