"""signals.py: the way from a signal to the KeyboardInterrupt that returns the vehicle."""

import signal
import sys
import threading
import time

import pytest

from flight_replay.signals import TERMINATION_SIGNALS, as_keyboard_interrupt, not_stopped

needs_job_control = pytest.mark.skipif(sys.platform == "win32", reason="Windows stops no programs")


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


def test_ctrl_backslash_is_a_termination_signal() -> None:
    """Left alone it ends the program at once, and the vehicle flies on without it."""
    assert getattr(signal, "SIGBREAK" if sys.platform == "win32" else "SIGQUIT") in TERMINATION_SIGNALS


@needs_job_control
def test_ctrl_z_is_ctrl_c_while_a_vehicle_is_flown() -> None:
    """Its handler of before is back afterwards, and further signals change nothing."""
    before = signal.getsignal(signal.SIGTSTP)
    with pytest.raises(KeyboardInterrupt), as_keyboard_interrupt(exits=False), not_stopped():
        try:
            signal.raise_signal(signal.SIGTSTP)
        finally:
            signal.raise_signal(signal.SIGTSTP)
            signal.raise_signal(signal.SIGINT)
            ended = "all of it"
    assert ended == "all of it"
    assert signal.getsignal(signal.SIGTSTP) == before


@needs_job_control
def test_output_to_a_terminal_of_another_program_does_not_stop_a_flight() -> None:
    """This would stop the test."""
    before = signal.getsignal(signal.SIGTTOU)
    with not_stopped():
        signal.raise_signal(signal.SIGTTOU)
    assert signal.getsignal(signal.SIGTTOU) == before


@needs_job_control
@pytest.mark.parametrize("name", ["SIGTSTP", "SIGTTOU"])
def test_an_ignored_stop_stays_ignored(name: str) -> None:
    """As other ignored signals do."""
    number = getattr(signal, name)
    before = signal.signal(number, signal.SIG_IGN)
    try:
        with not_stopped():
            signal.raise_signal(number)
        assert signal.getsignal(number) is signal.SIG_IGN
    finally:
        signal.signal(number, before)


def test_systems_without_job_control_have_nothing_to_change(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor is anything changed outside the main thread, where Python does not allow it."""
    for name in ("SIGTSTP", "SIGTTOU"):
        monkeypatch.delattr(signal, name, raising=False)
    with not_stopped():
        pass
    monkeypatch.undo()
    done: list[bool] = []

    def in_a_thread() -> None:
        with not_stopped():
            done.append(True)

    thread = threading.Thread(target=in_a_thread)
    thread.start()
    thread.join()
    assert done == [True]


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
