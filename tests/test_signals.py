"""signals.py: the way from a signal to the KeyboardInterrupt that returns the vehicle."""

import signal
import sys
import time

import pytest

from flight_replay.signals import TERMINATION_SIGNALS, as_keyboard_interrupt


class Interrupted:
    """Sends a signal when it is deleted, where Python drops what is raised."""

    def __init__(self, number: int) -> None:
        self.number = number

    def __del__(self) -> None:
        signal.raise_signal(signal.Signals(self.number))


@pytest.mark.parametrize("number", TERMINATION_SIGNALS)
def test_a_signal_that_python_drops_comes_again(number: int, capsys: pytest.CaptureFixture[str]) -> None:
    """Otherwise Ctrl-C while a module is imported would end nothing."""
    hook, handler = sys.unraisablehook, signal.getsignal(number)
    with pytest.raises(KeyboardInterrupt), as_keyboard_interrupt(exits=False):
        del_at_once = Interrupted(number)
        del del_at_once
        time.sleep(30.0)
    assert (sys.unraisablehook, signal.getsignal(number)) == (hook, handler)
    assert capsys.readouterr().err == ""


def test_further_signals_change_nothing_for_a_while() -> None:
    """They must not end the way home that the first one began."""
    with pytest.raises(KeyboardInterrupt), as_keyboard_interrupt(exits=False):
        try:
            signal.raise_signal(signal.SIGINT)
        finally:
            for number in TERMINATION_SIGNALS:
                signal.raise_signal(number)
            ended = "all of it"
    assert ended == "all of it"


def test_other_dropped_exceptions_are_told_as_before(monkeypatch: pytest.MonkeyPatch) -> None:
    """The hook of before has them."""
    told: list[type] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda dropped: told.append(dropped.exc_type))

    class Broken:
        def __del__(self) -> None:
            raise ValueError

    with as_keyboard_interrupt(exits=False):
        Broken()
    assert told == [ValueError]
