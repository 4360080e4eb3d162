"""The signals that end a program, and the exit status after one."""

from __future__ import annotations

import math
import os
import select
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType

INTERRUPTED_STATUS = 130
"""Exit status after any of the signals below, such as Ctrl-C, SIGTERM, or a terminal that was closed."""
TERMINATION_SIGNALS = tuple(
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGBREAK")
    if hasattr(signal, name)
)
"""The signals that ask a program to end, as far as this system has them."""
_STDERR = 2
_EXIT_TIMEOUT_S = 10.0
"""Wall-clock time in which a program exits after a signal; further signals are ignored meanwhile."""
_AGAIN_S = 0.05


def exit_at_once(message: str) -> None:
    """From now on, let the termination signals end the process with ``message`` on stderr.

    This is for a time in which there is nothing to tidy up: while the program is imported, which takes
    longer than most of what it does. A signal that is ignored (``nohup``) still is.
    """

    def end(*_: object) -> None:
        ignore()
        with suppress(OSError):
            if _takes_text(_STDERR):
                os.write(_STDERR, message.encode())
        os._exit(INTERRUPTED_STATUS)

    for number in TERMINATION_SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, end)


@contextmanager
def as_keyboard_interrupt(*, exits: bool = True) -> Iterator[None]:
    """Raise KeyboardInterrupt on all termination signals, so that they return the vehicle as Ctrl-C does.

    Further signals are ignored for some seconds: they must not keep RTL from being commanded. A signal
    that was ignored before (``nohup``) still is. Outside the main thread, signals are as they were.
    One that comes within a ``__del__`` or a callback of the importer, where Python drops exceptions, comes
    again a moment later.

    Args:
        exits: Whether the program exits after an interrupt, which more signals must then not end in
            another way; otherwise the handlers of before are back afterwards.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    interrupts = _Interrupts()
    before = {
        number: signal.signal(number, interrupts.handler)
        for number in TERMINATION_SIGNALS
        if signal.getsignal(number) is not signal.SIG_IGN
    }
    hook_before, sys.unraisablehook = sys.unraisablehook, interrupts.unraisable_hook
    try:
        yield
    finally:
        sys.unraisablehook = hook_before
        if not exits or math.isinf(interrupts.interrupted_s):
            for number, handler in before.items():
                signal.signal(number, handler)


@contextmanager
def not_stopped() -> Iterator[None]:
    """While a vehicle is flown, let Ctrl-Z do what Ctrl-C does: a program that is stopped cannot watch it.

    Nor does output to a terminal that is another program's by now (SIGTTOU) stop it; only before the
    vehicle is armed is something read there. A signal that was ignored before still is.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    wanted = {"SIGTSTP": signal.getsignal(signal.SIGINT), "SIGTTOU": signal.SIG_IGN}
    numbers = {getattr(signal, name): handler for name, handler in wanted.items() if hasattr(signal, name)}
    before = {
        number: signal.signal(number, handler)
        for number, handler in numbers.items()
        if signal.getsignal(number) is not signal.SIG_IGN
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class _Interrupts:
    """Raises one KeyboardInterrupt for all signals that come together, until it is noticed."""

    def __init__(self) -> None:
        self.interrupted_s = float("-inf")
        self._signal = signal.SIGINT
        self._other_hook = sys.unraisablehook

    def handler(self, number: int, _frame: FrameType | None) -> None:
        if time.monotonic() - self.interrupted_s > _EXIT_TIMEOUT_S:
            self.interrupted_s = time.monotonic()
            self._signal = signal.Signals(number)
            raise KeyboardInterrupt

    def unraisable_hook(self, dropped: sys.UnraisableHookArgs) -> None:
        if not issubclass(dropped.exc_type, KeyboardInterrupt):
            self._other_hook(dropped)
            return
        self.interrupted_s = float("-inf")
        again = threading.Timer(_AGAIN_S, _send, (self._signal,))
        again.daemon = True
        again.start()


def _send(number: signal.Signals) -> None:
    """Send a signal to the main thread, where it ends a wait too if the system can do that."""
    if sys.platform == "win32":
        signal.raise_signal(number)
    else:
        signal.pthread_kill(threading.main_thread().ident or 0, number)


def is_interrupt(error: BaseException) -> bool:
    """Whether an error is a KeyboardInterrupt, or came while one was on its way out.

    A condition variable whose wait is interrupted may be left without its lock, for example, and what
    is closed after it then raises a RuntimeError.
    """
    earlier = error.__context__
    return isinstance(error, KeyboardInterrupt) or (earlier is not None and is_interrupt(earlier))


def ignore() -> None:
    """Ignore the termination signals from now on: all is done, and the exit status stays what it is."""
    for number in TERMINATION_SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def _takes_text(descriptor: int) -> bool:
    """Whether writing to it does not block, as to a terminal that is stopped or a pipe that is full."""
    return sys.platform == "win32" or bool(select.select([], [descriptor], [], 0)[1])
