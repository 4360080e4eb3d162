"""A console that never holds up the flight: another thread writes to the terminal or pipe."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from typing import Any

from flight_replay.events import Event
from flight_replay.output.console.console import Console
from flight_replay.writing.background import Background, Call

QUEUED_LINES = 2000
_INTERRUPTED_CLOSE_S = 1.0


class BackgroundConsole:
    """Passes events and lines to the console that ``open_it`` opens, all on one thread of its own."""

    def __init__(self, open_it: Callable[[], AbstractContextManager[Console]]) -> None:
        self._thread = Background("console", QUEUED_LINES)
        self._context = open_it()
        self._console: Any = None
        self._reported = 0
        self._thread.submit(self._open)

    def _open(self) -> None:
        self._console = self._context.__enter__()

    def listener(self, event: Event) -> None:
        """Show an event soon, or drop it if the terminal does not keep up."""
        self._thread.submit(partial(self._show, event))

    def _show(self, event: Event) -> None:
        if self._thread.dropped > self._reported:
            self._console.print(f"({self._thread.dropped - self._reported} events not shown)")
            self._reported = self._thread.dropped
        self._console.listener(event)

    def print(self, text: str) -> None:
        """Print a line soon; after a flight it is worth waiting until it fits."""
        self._submit_when_it_fits(lambda: self._console.print(text))

    def _submit_when_it_fits(self, call: Call) -> None:
        while not self._thread.submit(call):
            self._thread.wait(None)

    def end_display(self, timeout_s: float) -> None:
        """End the display, if the terminal takes that within the time."""
        self._thread.submit(lambda: self._console.end_display(timeout_s))
        self.flush(timeout_s)

    def flush(self, timeout_s: float) -> bool:
        """Whether all has been written within the time."""
        return self._thread.wait(timeout_s)

    @contextmanager
    def paused(self) -> Iterator[None]:
        """The terminal is free for a question as long as the context lasts."""
        pause: list[AbstractContextManager[None]] = []

        def begin() -> None:
            pause.append(self._console.paused())
            pause[0].__enter__()

        self._submit_when_it_fits(begin)
        self._thread.wait(None)
        try:
            yield
        finally:
            self._submit_when_it_fits(lambda: pause[0].__exit__(None, None, None))

    def __enter__(self) -> BackgroundConsole:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: object, trace: object) -> None:
        """Wait until all is written; after an exception, no longer than a moment."""
        try:
            self._thread.close(
                None if kind is None else _INTERRUPTED_CLOSE_S,
                lambda: self._context.__exit__(None, None, None),
            )
        except KeyboardInterrupt:
            self._thread.close(_INTERRUPTED_CLOSE_S)
            raise
