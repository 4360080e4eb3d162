"""Log records as lines on stderr, which another thread writes: a terminal that is stopped delays nothing."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from flight_replay.output.console.terminal import PrintableFormatter, write_verbatim
from flight_replay.writing.background import Background

QUEUED_RECORDS = 1000
_CLOSE_S = 1.0


class _BackgroundHandler(logging.Handler):
    """Passes each record on as text; the supervisor and the link's thread log too, and must not wait."""

    def __init__(self, stream: TextIO, thread: Background) -> None:
        super().__init__()
        self._stream, self._thread = stream, thread
        self.setFormatter(PrintableFormatter(logging.BASIC_FORMAT))

    def emit(self, record: logging.LogRecord) -> None:
        """Write the record soon, or drop it if the stream does not keep up."""
        lines = self.format(record)
        self._thread.submit(lambda: write_verbatim(self._stream, lines))


@contextmanager
def log_lines(stream: TextIO, level: int) -> Iterator[None]:
    """Write the records of every logger from ``level`` on, for as long as the context lasts."""
    thread = Background("log", QUEUED_RECORDS)
    root, handler = logging.getLogger(), _BackgroundHandler(stream, thread)
    before = root.level
    handler.setLevel(level)
    root.addHandler(handler)
    root.setLevel(min(before, level))
    try:
        yield
    finally:
        root.removeHandler(handler)
        root.setLevel(before)
        thread.close(_CLOSE_S)
