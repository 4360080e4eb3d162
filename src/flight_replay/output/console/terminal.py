"""Writing to a stream that may be a terminal, a file or a closed pipe."""

from __future__ import annotations

import logging
import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import fields, replace
from typing import IO, Any, TextIO
from weakref import WeakKeyDictionary

from flight_replay.events import Event
from flight_replay.writing.terminal_text import escaped

_failures: WeakKeyDictionary[TextIO, OSError] = WeakKeyDictionary()


def is_capable_terminal(stream: TextIO, environment: Mapping[str, str] = os.environ) -> bool:
    """Whether the stream is a terminal that supports cursor movement and colours."""
    return stream.isatty() and environment.get("TERM", "").lower() not in {"dumb", "unknown"}


def write_error(
    stream: TextIO,
    message: str,
    environment: Mapping[str, str] = os.environ,
    *,
    program: str = "flight-replay",
) -> None:
    """Write ``flight-replay: error: ...`` as one line, in colour on a terminal unless NO_COLOR is set.

    The message may hold a newline, in a file name for example; it is escaped.
    """
    coloured = is_capable_terminal(stream, environment) and not environment.get("NO_COLOR")
    error = "\x1b[1;31merror:\x1b[0m" if coloured else "error:"
    write_verbatim(stream, f"{program}: {error} {printable(message, stream)}")


def show_cursor(*streams: TextIO) -> None:
    """Show the cursor, which a live display hides, on each stream that is a terminal."""
    for stream in streams:
        if is_capable_terminal(stream):
            with suppress(OSError):
                stream.write("\x1b[?25h")
                stream.flush()


def write_line(stream: TextIO, text: str) -> None:
    """Write a line; a stream that fails must not end a flight: ``flush_or_discard`` tells of it."""
    write_verbatim(stream, printable(text, stream))


def write_verbatim(stream: TextIO, text: str) -> None:
    """Write text that is our own, as it is, and a newline."""
    try:
        stream.write(text + "\n")
        stream.flush()
    except OSError as error:
        _failures[stream] = error


def flush_or_discard(stream: TextIO) -> str | None:
    """Flush a stream; why it failed, now or when a line was written, if it did.

    What is left is discarded: Python would try to write it again on exit. A reader that has exited
    (``| head``) is no failure.
    """
    failure = _failures.pop(stream, None)
    try:
        stream.flush()
    except OSError as error:
        failure = error
        with suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
            stream.flush()
    if failure is None or isinstance(failure, BrokenPipeError):
        return None
    name = str(getattr(stream, "name", "the output")).strip("<>")
    return f"cannot write {name}: {failure.strerror}; free some space, or write elsewhere"


def printable(text: str, stream: IO[str]) -> str:
    """The text as one line, with escapes for what moves the cursor or what the stream cannot encode."""
    encoding = getattr(stream, "encoding", None) or "utf-8"
    return escaped(text).encode(encoding, "backslashreplace").decode(encoding)


def printable_event(event: Event, stream: IO[str]) -> Event:
    """The event with its texts printable: they may come from an autopilot, a server or a file name."""
    texts: dict[str, Any] = {field.name: getattr(event, field.name) for field in fields(event)}
    texts = {name: printable(text, stream) for name, text in texts.items() if type(text) is str}
    return replace(event, **texts)


class PrintableFormatter(logging.Formatter):
    """Formats log records as printable lines."""

    def format(self, record: logging.LogRecord) -> str:
        """The lines of the record; a traceback has several."""
        return "\n".join(escaped(line) for line in super().format(record).split("\n"))
