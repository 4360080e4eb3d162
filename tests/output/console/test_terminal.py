"""terminal.py: errors and lines on terminals, files and closed pipes."""

import io
import logging

import pytest

from flight_replay.events import Event, Notice, Phase, PhaseStarted, Progress, Severity, StatusText, Waiting
from flight_replay.output.console.console import open_console
from flight_replay.output.console.terminal import (
    PrintableFormatter,
    is_capable_terminal,
    write_error,
    write_line,
)
from flight_replay.writing.terminal_text import escaped
from tests.helpers.streams import ClosedPipe, Terminal


def test_a_capable_terminal_can_move_its_cursor() -> None:
    """Files, pipes and TERM=dumb cannot."""
    assert is_capable_terminal(Terminal(), {"TERM": "xterm"})
    assert not is_capable_terminal(Terminal(), {"TERM": "dumb"})
    assert not is_capable_terminal(io.StringIO(), {"TERM": "xterm"})


@pytest.mark.parametrize(
    ("stream", "environment", "coloured"),
    [
        (Terminal(), {"TERM": "xterm"}, True),
        (Terminal(), {"TERM": "xterm", "NO_COLOR": "1"}, False),
        (Terminal(), {"TERM": "dumb"}, False),
        (io.StringIO(), {"TERM": "xterm"}, False),
    ],
    ids=["terminal", "no-color", "dumb", "file"],
)
def test_errors_are_coloured_on_a_terminal_only(
    stream: io.StringIO, environment: dict[str, str], coloured: bool
) -> None:
    """NO_COLOR and TERM=dumb are honoured; the text stays the same."""
    write_error(stream, "cannot read a.tlog", environment)
    written = stream.getvalue()
    assert ("\x1b[" in written) is coloured
    assert written.replace("\x1b[1;31m", "").replace("\x1b[0m", "") == (
        "flight-replay: error: cannot read a.tlog\n"
    )


def test_an_error_is_one_line_whatever_the_file_is_called() -> None:
    """A file name may hold newlines and terminal escapes."""
    stream = io.StringIO()
    write_error(stream, "cannot read two\nlines\x1b[31m ü.tlog")
    assert stream.getvalue() == "flight-replay: error: cannot read two\\nlines\\x1b[31m ü.tlog\n"


def test_characters_that_a_stream_cannot_encode_are_escaped() -> None:
    """A file name that is not valid UTF-8, or an ASCII terminal, raises no error."""
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding="ascii")
    write_line(stream, "Grüße an \udcff.tlog")
    assert raw.getvalue() == rb"Gr\xfc\xdfe an \udcff.tlog" + b"\n"


def test_a_closed_pipe_raises_no_error() -> None:
    """``flight-replay | head`` goes on without output."""
    write_line(ClosedPipe(), "Starting mission")
    write_error(ClosedPipe(), "lost")


HOSTILE = {
    "colour": "\x1b[31m",
    "title": "\x1b]0;title\x07",
    "clipboard": "\x1b]52;c;cm0gLXJm\x1b\\",
    "cursor back": "ok\r",
    "erase": "\x08\x08",
    "new line": "\nflight-replay: done",
    "tab": "\t",
    "null": "\x00",
    "DEL": "\x7f",
    "C1 CSI": "\x9b31m",
    "C1 OSC": "\x9d0;title\x9c",
    "next line": "\x85",
    "line separator": "\u2028",
    "right to left": "\u202egolt.exe",
    "embedding": "\u202a\u202b\u202c\u202d",
    "isolates": "\u2066\u2067\u2068\u2069",
    "marks": "\u200e\u200f\u061c",
    "no width": "\u200b\ufeff",
    "surrogate": "\udcff",
}
"""Texts that a terminal does not show as they are."""
PAINTED = "[red]name[/red] :smile:"
"""What rich would take for markup and emoji."""


def assert_harmless(written: str, text: str) -> None:
    """The text was written, with escapes that can be seen."""
    assert escaped(text) in written.replace("\n", "")
    assert not any(each in written for each in text if not each.isprintable() and each not in "\n\r\t\x1b")
    assert "\x1b]" not in written
    assert text not in written or text.isprintable()


@pytest.mark.parametrize("text", [*HOSTILE.values(), PAINTED], ids=[*HOSTILE, "markup"])
def test_texts_of_others_cannot_control_the_terminal(text: str) -> None:
    """Errors, lines, events of the autopilot and of the program, on a file and on a live terminal."""
    stream = io.StringIO()
    write_error(stream, f"cannot read {text}.tlog")
    assert_harmless(stream.getvalue(), text)
    events: list[Event] = [
        StatusText(Severity.WARNING, text),
        Notice(text, warning=True),
        PhaseStarted(Phase.CONNECT, text),
        Waiting(Phase.PREARM, text),
        Progress(text, 1, 2, "bytes"),
    ]
    for live in (False, True):
        for event in events:
            terminal = Terminal()
            with open_console(terminal, verbose=True, live=live) as console:
                console.listener(PhaseStarted(Phase.PREARM))
                console.listener(event)
                console.print(text)
            assert_harmless(terminal.getvalue(), text)


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
def test_log_records_cannot_control_the_terminal(text: str) -> None:
    """With -v DroneKit's log shows what the autopilot said; a traceback still has its lines."""
    stream = io.StringIO()
    handler = logging.StreamHandler(stream)
    handler.setFormatter(PrintableFormatter(logging.BASIC_FORMAT))
    logger = logging.Logger("autopilot")
    logger.addHandler(handler)
    try:
        raise ValueError
    except ValueError:
        logger.exception("says %s", text.replace("\n", ""))
    assert_harmless(stream.getvalue(), text.replace("\n", ""))
    assert stream.getvalue().splitlines()[1] == "Traceback (most recent call last):"


def test_ordinary_text_stays_as_it_is() -> None:
    """Letters of every language, and a picture."""
    text = "Grüße aus Zürich, 日本, שלום, привет 🚁 C:\\log"
    assert escaped(text) == text
