"""live_console.py: the display in place, and the lines above and below it."""

import errno

import pytest

from flight_replay.events import (
    DistanceToWaypoint,
    Event,
    Finished,
    Notice,
    Phase,
    PhaseStarted,
    ReturnCommanded,
    StatusText,
)
from flight_replay.output.console.live_console import LiveConsole
from tests.helpers.streams import Terminal

FLIGHT: list[Event] = [
    PhaseStarted(Phase.MISSION),
    StatusText(6, "Mission: 22 WP"),
    DistanceToWaypoint(23, 3.02, 100),
]


def run_live(verbose: bool, events: list[Event]) -> str:
    """Everything a live console writes."""
    stream = Terminal()
    with LiveConsole(stream, verbose=verbose) as console:
        console.print("Generating waypoints from tlog...")
        for event in events:
            console.listener(event)
        with console.paused():
            stream.write("question?")
    return stream.getvalue()


def test_text_and_notices_are_lines_above_the_display() -> None:
    """With -v every text of the autopilot is a line too."""
    events: list[Event] = [*FLIGHT, Notice("one thing", warning=True)]
    written = run_live(False, events)
    assert "Generating waypoints from tlog..." in written
    assert "Warning: one thing" in written
    assert "question?" in written
    assert ">>> Mission: 22 WP" not in written
    everything = run_live(True, events)
    assert ">>> Mission: 22 WP" in everything
    assert "Distance to waypoint" not in everything


def test_characters_that_cannot_be_encoded_are_escaped() -> None:
    """A file name may hold any bytes."""
    stream = Terminal()
    with LiveConsole(stream) as console:
        console.print("\udcff.tlog")
        console.listener(Notice("\udcfe.tlog"))
    assert r"\udcff.tlog" in stream.getvalue()
    assert r"\udcfe.tlog" in stream.getvalue()


def test_the_results_are_below_the_display() -> None:
    """Text after the end follows the last display."""
    stream = Terminal()
    with LiveConsole(stream) as console:
        console.listener(PhaseStarted(Phase.CLOSE))
        console.listener(Finished("duration"))
        console.print("Reached 22 of 100 waypoints")
    assert stream.getvalue().rindex("Reached 22") > stream.getvalue().rindex("Close")


def test_no_color_is_honoured_by_the_display(monkeypatch: pytest.MonkeyPatch) -> None:
    """With NO_COLOR no colour escape is written."""
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.delenv("NO_COLOR", raising=False)
    assert "\x1b[33m" in run_live(False, [Notice("x", warning=True)])
    monkeypatch.setenv("NO_COLOR", "1")
    assert "\x1b[33m" not in run_live(False, [Notice("x", warning=True)])


def test_a_closed_terminal_does_not_hide_an_interrupt() -> None:
    """After SIGHUP the terminal takes no more output; the interrupt goes on."""

    class Closed(Terminal):
        closed_now = False

        def write(self, text: str) -> int:
            if self.closed_now:
                raise OSError(errno.EIO, "Input/output error")
            return super().write(text)

    stream = Closed()
    with pytest.raises(KeyboardInterrupt), LiveConsole(stream) as console:
        console.listener(PhaseStarted(Phase.CONNECT))
        stream.closed_now = True
        raise KeyboardInterrupt


def test_an_interrupt_ends_with_what_became_of_the_vehicle() -> None:
    """Whether RTL is confirmed is a line; the display, whose mode is old by then, is gone."""
    stream = Terminal()
    with pytest.raises(KeyboardInterrupt), LiveConsole(stream) as console:
        for event in FLIGHT:
            console.listener(event)
        console.listener(ReturnCommanded(True))
        stream.seek(0)
        stream.truncate()
        raise KeyboardInterrupt
    assert "\x1b[2K" in stream.getvalue()  # Its lines are erased.
    with LiveConsole(stream) as console:
        console.listener(ReturnCommanded(True))
    assert " The vehicle confirmed RTL" in stream.getvalue()


def test_what_follows_a_display_that_is_ended_stands_below_it() -> None:
    """It is erased, and drawn no more."""
    stream = Terminal()
    with LiveConsole(stream) as console:
        console.listener(PhaseStarted(Phase.RETURN))
        console.end_display(1.0)
        ended = len(stream.getvalue())
        stream.write("Interrupted\n")
        console.listener(Notice("cannot write a.png", warning=True))
    assert "\x1b[2K" in stream.getvalue()[:ended]
    assert "\x1b[2K" not in stream.getvalue()[ended:]
