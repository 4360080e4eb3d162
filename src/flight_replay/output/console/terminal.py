"""Writing to a stream that may be a terminal, or gone."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from typing import IO, TextIO


def is_capable_terminal(stream: TextIO, environment: Mapping[str, str] = os.environ) -> bool:
    """Whether the stream is a terminal whose cursor can be moved (TERM=dumb says that it can't)."""
    return stream.isatty() and environment.get("TERM", "").lower() not in {"dumb", "unknown"}


def write_error(stream: TextIO, message: str, environment: Mapping[str, str] = os.environ) -> None:
    """``flight-replay: error: ...`` in one line, in colour on a terminal unless NO_COLOR is set.

    What does not show, as a newline in the name of a file, is written as Python escapes it.
    """
    coloured = is_capable_terminal(stream, environment) and not environment.get("NO_COLOR")
    error = "\x1b[1;31merror:\x1b[0m" if coloured else "error:"
    shown = "".join(each if each.isprintable() else repr(each)[1:-1] for each in message)
    write_line(stream, f"flight-replay: {error} {shown}")


def write_line(stream: TextIO, text: str) -> None:
    """Write lines; a stream that is gone must not end a flight."""
    with suppress(OSError):
        stream.write(printable(text, stream) + "\n")
        stream.flush()


def printable(text: str, stream: IO[str]) -> str:
    """The text in characters that the stream has: names of files need not be text at all."""
    encoding = getattr(stream, "encoding", None) or "utf-8"
    return text.encode(encoding, "backslashreplace").decode(encoding)
