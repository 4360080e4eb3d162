"""Events to plain lines, or to a live display on a terminal that can show one."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Protocol, TextIO

from flight_replay.events import Climbing, DistanceToWaypoint, Event, Waiting
from flight_replay.output.console.terminal import is_capable_terminal, write_line
from flight_replay.output.event_text import is_detail, sentence, went_wrong

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
    from flight_replay.output.console.live_console import LiveConsole

    with LiveConsole(stream, verbose=verbose) as console:
        yield console


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
            write_line(self._stream, text)

    def paused(self) -> AbstractContextManager[None]:
        """Lines need no pause."""
        return nullcontext()

    def listener(self, event: Event) -> None:
        """Write the event's line, if it has one worth a line now."""
        hidden = not went_wrong(event) if self._quiet else is_detail(event) and not self._verbose
        line = None if hidden or not self._is_due(event) else sentence(event)
        if line is not None:
            write_line(self._stream, line)

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
    if isinstance(event, DistanceToWaypoint):
        return event.seq, REPEAT_S
    return None, 0.0
