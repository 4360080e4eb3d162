"""consent.py: a real vehicle is armed only after a person has typed the word."""

import io
import os
import sys
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from flight_replay.cli import consent
from flight_replay.cli.consent import CONSENT_S, ArmingConsent, ask_consent
from flight_replay.events import VehicleState
from flight_replay.exceptions import MissionError, VehicleError
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


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
@pytest.mark.parametrize(("then", "consents"), [(b"no\n", False), (b"fly\n", True)])
def test_what_was_typed_before_the_question_is_no_answer(
    then: bytes, consents: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """At a real terminal, the word counts only after the question."""
    master, slave = os.openpty()
    with os.fdopen(slave, "r") as terminal:
        os.write(master, b"fly\n")
        monkeypatch.setattr("sys.stdin", terminal)
        monkeypatch.setattr("flight_replay.cli.consent._READ_S", 0.0)

        class Question(io.StringIO):
            def flush(self) -> None:
                os.write(master, then)

        monkeypatch.setattr("sys.stderr", Question())
        if consents:
            ask_consent(PlainConsole(io.StringIO()))
        else:
            with pytest.raises(VehicleError, match="'fly' was not typed"):
                ask_consent(PlainConsole(io.StringIO()))
    os.close(master)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_the_word_counts_only_after_a_second_of_the_briefing(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is typed while the briefing was not on the screen for a second yet is not read."""
    master, slave = os.openpty()
    moments: list[str | float] = []

    class Shown(PlainConsole):
        def flush(self, timeout_s: float) -> bool:
            moments.append("shown")
            return super().flush(timeout_s)

    def passes(seconds: float) -> None:
        moments.append(seconds)
        os.write(master, b"fly\n")

    class Question(io.StringIO):
        def flush(self) -> None:
            moments.append("asked")
            os.write(master, b"no\n")

    with os.fdopen(slave, "r") as terminal:
        monkeypatch.setattr("sys.stdin", terminal)
        monkeypatch.setattr("sys.stderr", Question())
        monkeypatch.setattr("time.sleep", passes)
        with pytest.raises(VehicleError, match="'fly' was not typed"):
            ask_consent(Shown(io.StringIO()))
    os.close(master)
    assert moments == ["shown", pytest.approx(1.0), "asked"]


def test_a_briefing_that_is_not_shown_is_no_consent(monkeypatch: pytest.MonkeyPatch) -> None:
    """Who did not see which vehicle it is cannot agree."""

    class Stuck(PlainConsole):
        def flush(self, timeout_s: float) -> bool:
            return False

    monkeypatch.setattr("sys.stdin", Terminal("fly\n"))
    with pytest.raises(VehicleError, match="not armed: the terminal does not show"):
        ask_consent(Stuck(io.StringIO()))


HERE = VehicleState(1.0, 47.0, 8.0, 0.0, (0, 0, 0), None, "GUIDED", False)


class Consents:
    """Consent with a clock that is set, and what a person saw."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *, asks: bool) -> None:
        self.now_s, self.shown = 100.0, list[str]()
        console: Any = SimpleNamespace(print=self.shown.append)
        monkeypatch.setattr(consent, "_check_terminal", lambda: None)
        monkeypatch.setattr(consent, "ask_consent", lambda console: self.shown.append("asked"))
        self._confirm = ArmingConsent(console, self._checked, asks=asks, clock_s=lambda: self.now_s)

    def _checked(self, state: VehicleState) -> list[str]:
        if state.lat_deg > 47.5:
            raise MissionError("too far")
        return [f"at {state.lat_deg}"]

    def at(self, now_s: float, lat_deg: float = 47.0) -> tuple[bool, list[str]]:
        """Whether a person was asked before a request to arm, and what was shown."""
        self.now_s = now_s
        self.shown.clear()
        return self._confirm(lambda: replace(HERE, lat_deg=lat_deg)), list(self.shown)


def test_the_word_lapses(monkeypatch: pytest.MonkeyPatch) -> None:
    """It counts for ten seconds of requests; later it is asked for again, with where the vehicle is then."""
    consents = Consents(monkeypatch, asks=True)
    assert consents.at(200.0) == (True, ["at 47.0", "asked"])
    assert consents.at(200.0 + CONSENT_S) == (False, [])
    asked, shown = consents.at(201.0 + CONSENT_S, 47.1)
    assert asked
    assert shown == ["The word counts for 10 s only, and the vehicle is not armed.", "at 47.1", "asked"]
    assert consents.at(202.0 + CONSENT_S) == (False, [])
    with pytest.raises(MissionError, match="too far"):
        consents.at(400.0, 48.0)


def test_with_yes_nobody_is_asked_but_told_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """That the motors will start, if the vehicle was shown more than ten seconds ago; it may be too far."""
    consents = Consents(monkeypatch, asks=False)
    assert consents.at(105.0) == (False, [])
    asked, shown = consents.at(176.0)
    assert not asked
    assert shown == ["The motors will start, without a question (--yes). Stand clear."]
    assert consents.at(180.0) == (False, [])
    with pytest.raises(MissionError, match="too far"):
        consents.at(400.0, 48.0)
