"""Events to plain lines, or to a live display on a terminal that can show one."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from typing import IO, Protocol, TextIO

from flight_replay.events import Climbing, Event, Heading, Waiting
from flight_replay.wording import is_detail, sentence, went_wrong

REPEAT_S = 1.0
"""DroneKit's example repeats a reading once a second, by the clock here."""
REASON_REPEAT_S = 5.0
"""A wait whose reason stays the same is repeated more seldom."""


class Console(Protocol):
    """What a person sees of a replay."""

    def listener(self, event: Event) -> None:
        """Show an event."""

    def say(self, text: str) -> None:
        """Show text of ours, on lines of its own."""

    def paused(self) -> AbstractContextManager[None]:
        """The time in which a question is asked at the terminal."""


@contextmanager
def open_console(
    stream: TextIO, *, quiet: bool = False, verbose: bool = False, live: bool | None = None
) -> Iterator[Console]:
    """A console on ``stream``: live where that is a terminal that can be (or as told), else plain lines.

    ``quiet`` keeps only what went wrong, ``verbose`` adds everything that the autopilot says.
    """
    if quiet or not (is_capable_terminal(stream) if live is None else live):
        yield PlainConsole(stream, quiet=quiet, verbose=verbose)
        return
    # Rich costs a tenth of a second, which a run that is not watched need not pay.
    from flight_replay.live import LiveConsole

    with LiveConsole(stream, verbose=verbose) as console:
        yield console


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
    _write(stream, f"flight-replay: {error} {shown}")


def _write(stream: TextIO, text: str) -> None:
    """Write lines; a stream that is gone must not end a flight."""
    with suppress(OSError):
        stream.write(printable(text, stream) + "\n")
        stream.flush()


def printable(text: str, stream: IO[str]) -> str:
    """The text in characters that the stream has: names of files need not be text at all."""
    encoding = getattr(stream, "encoding", None) or "utf-8"
    return text.encode(encoding, "backslashreplace").decode(encoding)


class PlainConsole:
    """One line an event; readings that repeat themselves, once a second."""

    def __init__(
        self,
        stream: TextIO,
        *,
        quiet: bool = False,
        verbose: bool = False,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._stream = stream
        self._quiet = quiet
        self._verbose = verbose
        self._clock = clock
        self._said: dict[object, tuple[object, float]] = {}

    def say(self, text: str) -> None:
        """Write text of ours, unless quiet."""
        if not self._quiet:
            _write(self._stream, text)

    def paused(self) -> AbstractContextManager[None]:
        """Lines need no pause."""
        return nullcontext()

    def listener(self, event: Event) -> None:
        """Write the event's line, if it has one worth a line now."""
        hidden = not went_wrong(event) if self._quiet else is_detail(event) and not self._verbose
        line = None if hidden or not self._is_due(event) else sentence(event)
        if line is not None:
            _write(self._stream, line)

    def _is_due(self, event: Event) -> bool:
        """Whether a repeated reading says something new, or the last was said long enough ago."""
        value, every_s = _repeated(event)
        if every_s == 0:
            return True
        now_s = self._clock()
        value_before, said_s = self._said.get(type(event), (None, -every_s))
        if value == value_before and now_s - said_s < every_s:
            return False
        self._said[type(event)] = (value, now_s)
        return True


def _repeated(event: Event) -> tuple[object, float]:
    """What makes a repeated reading new, and the seconds after which an old one is said again."""
    if isinstance(event, Waiting):
        return event, REASON_REPEAT_S if event.reason else REPEAT_S
    if isinstance(event, Climbing):
        return event.target_m, REPEAT_S
    if isinstance(event, Heading):
        return event.seq, REPEAT_S
    return None, 0.0
