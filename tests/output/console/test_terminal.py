"""terminal.py: errors and lines on terminals, files and closed pipes."""

import io

import pytest

from flight_replay.output.console.terminal import is_capable_terminal, write_error, write_line
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
