"""A console that is drawn over itself, on a terminal that can."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import TracebackType
from typing import TextIO

from rich.console import Console as RichConsole
from rich.live import Live
from rich.text import Text

from flight_replay.events import (
    Climbing,
    DistanceToWaypoint,
    Event,
    Finished,
    Notice,
    PhaseStarted,
    Progress,
    Waiting,
)
from flight_replay.output.console.display import Display
from flight_replay.output.console.terminal import printable
from flight_replay.output.event_text import sentence, went_wrong
from flight_replay.output.replay_status import Status

REFRESHES_PER_S = 8
_SHOWN = PhaseStarted | Progress | Waiting | Climbing | DistanceToWaypoint
"""What the display itself shows, and need not scroll by as well."""


class LiveConsole:
    """A display that is drawn over itself; text of ours scrolls by above it."""

    def __init__(self, stream: TextIO, *, verbose: bool = False) -> None:
        self._rich = RichConsole(file=stream, highlight=False, force_terminal=True)
        self._verbose = verbose
        self._status = Status()
        self._live = Live(
            get_renderable=lambda: Display(self._status),
            console=self._rich,
            refresh_per_second=REFRESHES_PER_S,
            redirect_stdout=False,
            redirect_stderr=False,
        )

    def __enter__(self) -> LiveConsole:
        self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop()

    def _stop(self) -> None:
        with suppress(OSError):  # A terminal that was closed must not hide what ended the program.
            self._live.stop()

    def listener(self, event: Event) -> None:
        """Take the event into the display; notices, and everything if verbose, also scroll by."""
        self._status.update(event)
        line = sentence(event) if self._scrolls(event) else None
        if line is not None:
            self._print(Text(printable(line, self._rich.file), style="yellow" if went_wrong(event) else ""))
        if isinstance(event, Finished):
            self._stop()  # What is said from now on stands below the display.

    def _scrolls(self, event: Event) -> bool:
        return (
            isinstance(event, Notice)
            or went_wrong(event)
            or (self._verbose and not isinstance(event, _SHOWN))
        )

    def say(self, text: str) -> None:
        """Print text of ours above the display."""
        self._print(Text(printable(text, self._rich.file)))

    def _print(self, text: Text) -> None:
        with suppress(OSError):  # A terminal that is gone must not end a flight.
            self._rich.print(text)

    @contextmanager
    def paused(self) -> Iterator[None]:
        """Take the display away while a question is asked."""
        self._live.stop()
        try:
            yield
        finally:
            self._live.start()
