"""background_console.py: what a terminal that does not keep up was not shown is counted."""

from __future__ import annotations

import io
import threading
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext

import pytest

from flight_replay.events import Notice
from flight_replay.output.console.background_console import QUEUED_LINES, BackgroundConsole
from flight_replay.output.console.console import Console, PlainConsole, open_console


class Slow(io.StringIO):
    """A terminal that takes nothing until it is free."""

    def __init__(self) -> None:
        super().__init__()
        self.free, self._begun = threading.Event(), threading.Event()

    def write(self, text: str) -> int:
        """Write once it is free."""
        self._begun.set()
        self.free.wait(60)
        return super().write(text)

    def fill(self, console: BackgroundConsole) -> None:
        """Have 30 lines more wait than are kept."""
        console.listener(Notice("first"))
        assert self._begun.wait(60)
        for _ in range(QUEUED_LINES + 30):
            console.listener(Notice("many"))


def test_events_that_were_dropped_are_counted() -> None:
    """Once, where they are missing; what comes later is shown."""
    stream = Slow()
    with BackgroundConsole(lambda: open_console(stream)) as console:
        stream.fill(console)
        stream.free.set()
        assert console.flush(60)
        for _ in range(2):
            console.listener(Notice("last"))
        assert console.flush(60)
    lines = stream.getvalue().splitlines()
    assert lines.count("(30 events not shown)") == 1
    assert lines[-2:] == ["last", "last"]
    assert len(lines) == QUEUED_LINES + 4


def test_a_full_queue_leaves_the_console_closed() -> None:
    """What closes the console gives the terminal back: it is not dropped with the events."""
    stream, closed = Slow(), list[bool]()

    @contextmanager
    def opened() -> Iterator[Console]:
        with open_console(stream) as console:
            yield console
        closed.append(True)

    with BackgroundConsole(opened) as console:
        stream.fill(console)
        threading.Timer(0.05, stream.free.set).start()
    assert closed == [True]


def test_a_question_waits_until_the_events_are_shown(caplog: pytest.LogCaptureFixture) -> None:
    """Even if no more of them fit."""
    stream = Slow()
    with BackgroundConsole(lambda: open_console(stream)) as console:
        stream.fill(console)
        threading.Timer(0.05, stream.free.set).start()
        with console.paused():
            assert "many" in stream.getvalue()
    assert not caplog.records


def test_a_display_is_not_waited_for_that_does_not_end() -> None:
    """As on a terminal that is stopped."""
    go_on = threading.Event()

    class Stuck(PlainConsole):
        def end_display(self, timeout_s: float) -> None:
            go_on.wait(60.0)

    with BackgroundConsole(lambda: nullcontext(Stuck(io.StringIO()))) as console:
        console.end_display(0.0)
        assert not console.flush(0.0)
        go_on.set()
