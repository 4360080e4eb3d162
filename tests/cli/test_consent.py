"""A real vehicle is armed only when a person says so."""

import io

import pytest

from flight_replay.cli.consent import ask_consent
from flight_replay.errors import VehicleError
from flight_replay.output.console.console import PlainConsole


class Terminal(io.StringIO):
    """A terminal at which an answer was typed."""

    def isatty(self) -> bool:
        """Say that a person sits here."""
        return True


def ask(monkeypatch: pytest.MonkeyPatch, stdin: io.StringIO) -> None:
    """Ask with this standard input."""
    monkeypatch.setattr("sys.stdin", stdin)
    ask_consent(PlainConsole(io.StringIO()))


@pytest.mark.parametrize("answer", ["fly\n", " FLY \n"])
def test_the_word_is_enough(
    answer: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The word that was asked for, in whatever case, is consent; the question goes to stderr."""
    ask(monkeypatch, Terminal(answer))
    said = capsys.readouterr()
    assert "type fly" in said.err
    assert said.out == ""


@pytest.mark.parametrize("answer", ["\n", "yes\n", "no\n", ""])
def test_anything_else_is_not(answer: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Enter, a yes out of habit, or the end of input arm nothing."""
    with pytest.raises(VehicleError, match="not armed"):
        ask(monkeypatch, Terminal(answer))


def test_without_a_terminal_nobody_can_consent(monkeypatch: pytest.MonkeyPatch) -> None:
    """A script must say --yes."""
    with pytest.raises(VehicleError, match="--yes"):
        ask(monkeypatch, io.StringIO("fly\n"))


def test_a_terminal_that_is_closed_consents_to_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reading from a terminal that is gone fails; nothing is armed for that."""

    class Closed(Terminal):
        def readline(self, size: int | None = -1, /) -> str:  # type: ignore[override]
            raise OSError(5, "Input/output error")

    with pytest.raises(VehicleError, match="not armed"):
        ask(monkeypatch, Closed())
