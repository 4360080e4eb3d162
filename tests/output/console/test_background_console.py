"""background_console.py: what a terminal that does not keep up was not shown is counted."""

from __future__ import annotations

import io
import threading

from flight_replay.events import Notice
from flight_replay.output.console.background_console import QUEUED_LINES, BackgroundConsole
from flight_replay.output.console.console import open_console


def test_events_that_were_dropped_are_counted() -> None:
    """Once, where they are missing; what comes later is shown."""
    free, begun = threading.Event(), threading.Event()

    class Slow(io.StringIO):
        def write(self, text: str) -> int:
            begun.set()
            free.wait(60)
            return super().write(text)

    stream = Slow()
    with BackgroundConsole(lambda: open_console(stream)) as console:
        console.listener(Notice("first"))
        assert begun.wait(60)
        for _ in range(QUEUED_LINES + 30):
            console.listener(Notice("many"))
        free.set()
        assert console.flush(60)
        for _ in range(2):
            console.listener(Notice("last"))
        assert console.flush(60)
    lines = stream.getvalue().splitlines()
    assert lines.count("(30 events not shown)") == 1
    assert lines[-2:] == ["last", "last"]
    assert len(lines) == QUEUED_LINES + 4
