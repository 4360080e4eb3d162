"""Reads XML of any size and origin: without entities or document types, and in bounded memory.

Tracks are read while they come in. What does not end, or holds anything but a track for long, is
refused before it costs time or memory: see the bounds below.
"""

from __future__ import annotations

from codecs import BOM_UTF8
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol
from xml.parsers import expat

from flight_replay.exceptions import LogError
from flight_replay.logs.tracks.track_points import MOST_POINTS

_MOST_BYTES = 256 << 20
_MOST_IDLE_BYTES = 8 << 20
"""Without a point in so much a file is not a track; pictures and styles stand beside it."""
_MOST_IDLE_ELEMENTS = 200_000
"""A second's work."""
_VALUES_OF_A_POINT = 3
"""A track of KML has all times first, then the places, then the headings."""
_LONGEST_MARK = 1 << 20
"""Older versions of expat take time by the square of the length of a tag or a comment."""
_DEEPEST, _MOST_NAMES = 100, 10_000
_LONGEST_TEXT = 4096


class ElementReader(Protocol):
    """What is told of a file's elements, by their names without prefixes."""

    def start(self, name: str, attributes: dict[str, str]) -> None:
        """An element begins."""
        ...

    def end(self, name: str, text: str) -> None:
        """It ends; ``text`` is its first 4096 characters, of those behind its last child."""
        ...

    def text(self, text: str) -> bool:
        """Whether a piece of text was taken, which then is no part of ``end``'s."""
        ...

    def __len__(self) -> int:
        """How many places, times and headings of points were read so far, those of others counted as one."""
        ...


@dataclass(frozen=True, slots=True)
class XmlEnd:
    """How the reading of a file ended: after so many bytes, and at which fault, if any."""

    bytes: int
    fault: str | None

    def notes(self) -> list[str]:
        """A sentence about the fault, if there is one."""
        return [f"It is read up to a fault in its XML: {self.fault}"] if self.fault else []


def read_xml(pieces: Iterable[bytes], reader: ElementReader, name: str) -> XmlEnd:
    """Read a file in pieces, up to its end or the first fault.

    Args:
        pieces: The bytes of the file; white space before its first mark is left out.
        reader: Told of all elements.
        name: The file's, for errors.

    Raises:
        LogError: It is made to keep the reader busy.
    """
    parser = _Parser(reader, name)
    begun = False
    for piece in pieces:
        data = piece if begun else piece.removeprefix(BOM_UTF8).lstrip(b" \t\r\n")
        begun = begun or bool(data)
        fault = parser.feed(data, last=False)
        if fault:
            return XmlEnd(parser.fed, fault)
    return XmlEnd(parser.fed, parser.feed(b"", last=True))


class _Parser:
    """An expat parser with bounds."""

    def __init__(self, reader: ElementReader, name: str) -> None:
        self._reader, self._name = reader, name
        self._names: dict[str, str] = {}
        self._text: list[str] = []
        self._length = self._depth = self._idle = 0
        self._points = self._productive_at = self.fed = 0
        self._expat = expat.ParserCreate(None, None, self._names)
        self._expat.buffer_text = True
        self._expat.StartElementHandler = self._start
        self._expat.EndElementHandler = self._end
        self._expat.CharacterDataHandler = self._characters
        self._expat.StartDoctypeDeclHandler = self._refuse_doctype

    def feed(self, data: bytes, *, last: bool) -> str | None:
        """Read on; returns the fault that ends the reading, if there is one."""
        self.fed += len(data)
        try:
            self._expat.Parse(data, last)
        except expat.ExpatError as error:
            return f"{expat.ErrorString(error.code)}, line {error.lineno}"
        except (LookupError, ValueError):  # an encoding that Python has none for
            return "unknown encoding"
        self._check()
        return None

    def _check(self) -> None:
        """Refuse what is no track."""
        if len(self._reader) > _VALUES_OF_A_POINT * MOST_POINTS:
            self._refuse(f"has more than {MOST_POINTS} points")
        if len(self._reader) > self._points:
            self._points, self._productive_at, self._idle = len(self._reader), self.fed, 0
        if self.fed - self._productive_at > _MOST_IDLE_BYTES:
            self._refuse(f"has no point of a track in {_MOST_IDLE_BYTES >> 20} MB")
        if self._idle > _MOST_IDLE_ELEMENTS:
            self._refuse(f"has no point of a track in {_MOST_IDLE_ELEMENTS} elements")
        if self.fed - max(self._expat.CurrentByteIndex, 0) > _LONGEST_MARK:
            self._refuse(f"has a tag or a comment of more than {_LONGEST_MARK >> 20} MB")
        if self.fed > _MOST_BYTES:
            self._refuse(f"is larger than {_MOST_BYTES >> 20} MB")
        if len(self._names) > _MOST_NAMES:
            self._refuse(f"has more than {_MOST_NAMES} kinds of elements")

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        self._depth += 1
        self._idle += 1
        if self._depth > _DEEPEST:
            self._refuse(f"has elements more than {_DEEPEST} deep")
        self._forget_text()
        self._reader.start(self._without_prefix(name), attributes)

    def _end(self, name: str) -> None:
        self._depth -= 1
        text = "".join(self._text)
        self._forget_text()
        self._reader.end(self._without_prefix(name), text)

    def _characters(self, text: str) -> None:
        if self._length < _LONGEST_TEXT and not self._reader.text(text):
            self._text.append(text[: _LONGEST_TEXT - self._length])
            self._length += len(text)

    def _forget_text(self) -> None:
        if self._length:
            self._text, self._length = [], 0

    def _without_prefix(self, name: str) -> str:
        return name.rpartition(":")[2] if ":" in name else name

    def _refuse_doctype(self, *_: object) -> None:
        self._refuse("declares a document type, which tracks do not need and which can hide anything")

    def _refuse(self, why: str) -> None:
        raise LogError(f"{self._name} {why}; name a file with just the track")
