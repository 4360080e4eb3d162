"""Writing to a stream that may be a terminal, a file or a closed pipe."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from typing import IO, TextIO


def is_capable_terminal(stream: TextIO, environment: Mapping[str, str] = os.environ) -> bool:
    """Whether the stream is a terminal that supports cursor movement and colours."""
    return stream.isatty() and environment.get("TERM", "").lower() not in {"dumb", "unknown"}


def write_error(stream: TextIO, message: str, environment: Mapping[str, str] = os.environ) -> None:
    """Write ``flight-replay: error: ...`` as one line, in colour on a terminal unless NO_COLOR is set.

    Characters that are not printable, such as a newline in a file name, are written as Python escapes.
    """
    coloured = is_capable_terminal(stream, environment) and not environment.get("NO_COLOR")
    error = "\x1b[1;31merror:\x1b[0m" if coloured else "error:"
    escaped = "".join(each if each.isprintable() else repr(each)[1:-1] for each in message)
    write_line(stream, f"flight-replay: {error} {escaped}")


def write_line(stream: TextIO, text: str) -> None:
    """Write a line; a stream that is closed must not end a flight."""
    with suppress(OSError):
        stream.write(printable(text, stream) + "\n")
        stream.flush()


def printable(text: str, stream: IO[str]) -> str:
    """The text with escapes for what the stream cannot encode; a file name may hold any bytes."""
    encoding = getattr(stream, "encoding", None) or "utf-8"
    return text.encode(encoding, "backslashreplace").decode(encoding)
