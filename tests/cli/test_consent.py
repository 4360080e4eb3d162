"""consent.py: a real vehicle is armed only after a person has typed the word."""

import io

import pytest

from flight_replay.cli.consent import ask_consent
from flight_replay.errors import VehicleError
from flight_replay.output.console.console import PlainConsole


class Terminal(io.StringIO):
    """A terminal at which an answer is typed."""

    def isatty(self) -> bool:
        return True


def ask(monkeypatch: pytest.MonkeyPatch, stdin: io.StringIO) -> None:
    """Ask for consent with this standard input."""
    monkeypatch.setattr("sys.stdin", stdin)
    monkeypatch.setattr("flight_replay.cli.consent._READ_S", 0.0)
    ask_consent(PlainConsole(io.StringIO()))


@pytest.mark.parametrize("answer", ["fly\n", " FLY \n"])
def test_the_word_is_consent(
    answer: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """In upper or lower case; the question goes to stderr."""
    ask(monkeypatch, Terminal(answer))
    output = capsys.readouterr()
    assert "type 'fly'" in output.err
    assert output.out == ""


@pytest.mark.parametrize("answer", ["\n", "yes\n", "no\n", ""])
def test_any_other_answer_is_not(answer: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither Enter, nor yes, nor the end of input."""
    with pytest.raises(VehicleError, match="not armed: 'fly' was not typed"):
        ask(monkeypatch, Terminal(answer))


def test_without_a_terminal_there_is_no_consent(monkeypatch: pytest.MonkeyPatch) -> None:
    """A script has to use --yes."""
    with pytest.raises(VehicleError, match="--yes"):
        ask(monkeypatch, io.StringIO("fly\n"))


def test_a_closed_terminal_is_no_consent(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reading from it fails, and the vehicle is not armed."""

    class Closed(Terminal):
        def readline(self, size: int | None = -1, /) -> str:  # type: ignore[override]
            raise OSError(5, "Input/output error")

    with pytest.raises(VehicleError, match="not armed: 'fly' was not typed"):
        ask(monkeypatch, Closed())
