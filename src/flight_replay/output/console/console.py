"""Shows events as plain lines, or as a live display on a terminal that supports one."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Protocol, TextIO

from flight_replay.events import Climbing, DistanceToStart, DistanceToWaypoint, Event, Following, Waiting
from flight_replay.output.console.terminal import is_capable_terminal, write_line
from flight_replay.output.event_text import event_line, is_detail, is_problem

REPEAT_S = 1.0
"""Wall-clock time between two lines of a repeated reading, as in DroneKit's example."""
WAIT_REPEAT_S = 5.0
"""Wall-clock time between two lines of a wait whose reason stays the same."""


class Console(Protocol):
    """Shows a replay to a person."""

    def listener(self, event: Event) -> None:
        """Show an event."""

    def print(self, text: str) -> None:
        """Show a line of text."""

    def paused(self) -> AbstractContextManager[None]:
        """A context in which the terminal is free for a question."""

    def end_display(self, timeout_s: float) -> None:
        """End a display that is redrawn in place, within the time: what follows stands below it."""

    def flush(self, timeout_s: float) -> bool:
        """Whether all has been written within the time."""


@contextmanager
def open_console(
    stream: TextIO,
    *,
    quiet: bool = False,
    verbose: bool = False,
    live: bool | None = None,
    mode: str = "auto",
) -> Iterator[Console]:
    """A console on ``stream``.

    Args:
        stream: Where to write.
        quiet: Show warnings only.
        verbose: Show every text of the autopilot.
        live: Use the live display; by default, where ``stream`` is a terminal that supports it.
        mode: The way of flying, "auto" or "guided", whose phases the live display shows.
    """
    if quiet or not (is_capable_terminal(stream) if live is None else live):
        yield PlainConsole(stream, quiet=quiet, verbose=verbose)
        return
    # Importing rich takes 0.1 s, which a replay without a terminal saves.
    from flight_replay.output.console.live_console import LiveConsole

    with LiveConsole(stream, verbose=verbose, mode=mode) as console:
        yield console


class PlainConsole:
    """Writes a line for each event; repeated readings at most once a second."""

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
        self._last_shown: dict[object, tuple[object, float]] = {}

    def print(self, text: str) -> None:
        """Write a line of text, unless quiet."""
        if not self._quiet:
            write_line(self._stream, text)

    def paused(self) -> AbstractContextManager[None]:
        """Plain lines leave the terminal free."""
        return nullcontext()

    def end_display(self, timeout_s: float) -> None:
        """Plain lines follow each other."""

    def flush(self, timeout_s: float) -> bool:
        """Each line is written at once."""
        return True

    def listener(self, event: Event) -> None:
        """Write the event's line, if it has one that is due."""
        hidden = not is_problem(event) if self._quiet else is_detail(event) and not self._verbose
        line = None if hidden or not self._is_due(event) else event_line(event)
        if line is not None:
            write_line(self._stream, line)

    def _is_due(self, event: Event) -> bool:
        """Whether a reading has changed, or was last shown long enough ago."""
        key, repeat_s = _repetition(event)
        if repeat_s == 0:
            return True
        now_s = self._clock()
        last_key, shown_s = self._last_shown.get(type(event), (None, -repeat_s))
        if key == last_key and now_s - shown_s < repeat_s:
            return False
        self._last_shown[type(event)] = (key, now_s)
        return True


def _repetition(event: Event) -> tuple[object, float]:
    """A key that changes when the event is new, and the seconds until the same key is shown again."""
    if isinstance(event, Waiting):
        return event, WAIT_REPEAT_S if event.reason else REPEAT_S
    if isinstance(event, Climbing):
        return event.target_m, REPEAT_S
    if isinstance(event, DistanceToWaypoint):
        return event.seq, REPEAT_S
    if isinstance(event, DistanceToStart):
        return None, REPEAT_S
    if isinstance(event, Following):
        return event.recording_s < 0, REPEAT_S
    return None, 0.0
