"""A console with a live display that is redrawn in place."""

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
    DistanceToStart,
    DistanceToWaypoint,
    Event,
    Finished,
    Following,
    Notice,
    PhaseStarted,
    Progress,
    ReturnCommanded,
    Waiting,
)
from flight_replay.output.console.display import Display
from flight_replay.output.console.terminal import printable, printable_event
from flight_replay.output.event_text import event_line, is_problem
from flight_replay.output.replay_status import ReplayStatus

REFRESHES_PER_S = 8
_IN_DISPLAY = PhaseStarted | Progress | Waiting | Climbing | DistanceToStart | DistanceToWaypoint | Following
"""Events that the display itself shows, so that they need no line above it."""


class LiveConsole:
    """Shows the status of the replay, and lines of text that scroll above it.

    ``mode`` is the way of flying, "auto" or "guided".
    """

    def __init__(self, stream: TextIO, *, verbose: bool = False, mode: str = "auto") -> None:
        self._rich = RichConsole(file=stream, highlight=False, force_terminal=True)
        self._verbose = verbose
        self._status = ReplayStatus()
        self._live = Live(
            get_renderable=lambda: Display(self._status, mode),
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
        if kind is None:
            self._stop()
        else:
            self.end_display(0.0)

    def end_display(self, timeout_s: float) -> None:
        """End the display, and erase it: what it showed last is not what became of the vehicle."""
        self._live.transient = True
        self._stop()

    def _stop(self) -> None:
        with suppress(OSError):  # A closed terminal must not hide the exception that ends the program.
            self._live.stop()

    def listener(self, event: Event) -> None:
        """Show the event in the display; notices, problems and, if verbose, the rest are lines as well."""
        event = printable_event(event, self._rich.file)
        self._status.update(event)
        line = event_line(event) if self._has_line(event) else None
        if line is not None:
            self._write(Text(line, style="yellow" if is_problem(event) else ""))
        if isinstance(event, Finished):
            self._stop()  # The results are printed below the display.

    def _has_line(self, event: Event) -> bool:
        return (
            isinstance(event, Notice | ReturnCommanded)
            or is_problem(event)
            or (self._verbose and not isinstance(event, _IN_DISPLAY))
        )

    def print(self, text: str) -> None:
        """Print a line of text above the display."""
        self._write(Text(printable(text, self._rich.file)))

    def _write(self, text: Text) -> None:
        with suppress(OSError):  # A closed terminal must not end a flight.
            self._rich.print(text)

    def flush(self, timeout_s: float) -> bool:
        """Each line is written at once."""
        return True

    @contextmanager
    def paused(self) -> Iterator[None]:
        """Hide the display while a question is asked."""
        self._live.stop()
        try:
            yield
        finally:
            self._live.start()
