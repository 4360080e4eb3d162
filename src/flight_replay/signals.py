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
"""Exit status after Ctrl-C, SIGTERM, or a terminal that was closed."""
TERMINATION_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)
"""The signals that ask a program to end, as far as this system has them."""
_STDERR = 2
_EXIT_TIMEOUT_S = 10.0
"""Wall-clock time in which a program exits after a signal; further signals are ignored meanwhile."""


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
    """Raise KeyboardInterrupt on SIGTERM and SIGHUP too, so that they return the vehicle as Ctrl-C does.

    Further signals are ignored for some seconds: they must not keep RTL from being commanded. A signal
    that was ignored before (``nohup``) still is. Outside the main thread, signals are as they were.

    Args:
        exits: Whether the program exits after an interrupt, which more signals must then not end in
            another way; otherwise the handlers of before are back afterwards.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    interrupted_s = float("-inf")

    def interrupt(_signal: int, _frame: FrameType | None) -> None:
        nonlocal interrupted_s
        if time.monotonic() - interrupted_s > _EXIT_TIMEOUT_S:
            interrupted_s = time.monotonic()
            raise KeyboardInterrupt

    before = {
        number: signal.signal(number, interrupt)
        for number in TERMINATION_SIGNALS
        if signal.getsignal(number) is not signal.SIG_IGN
    }
    try:
        yield
    finally:
        if not exits or math.isinf(interrupted_s):
            for number, handler in before.items():
                signal.signal(number, handler)


def ignore() -> None:
    """Ignore the termination signals from now on: all is done, and the exit status stays what it is."""
    for number in TERMINATION_SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def _takes_text(descriptor: int) -> bool:
    """Whether writing to it does not block, as to a terminal that is stopped or a pipe that is full."""
    return sys.platform == "win32" or bool(select.select([], [descriptor], [], 0)[1])
