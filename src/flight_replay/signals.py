"""The signals that end a program, and the exit status after one."""

from __future__ import annotations

import os
import select
import signal
import sys
from contextlib import suppress

INTERRUPTED_STATUS = 130
"""Exit status after Ctrl-C, SIGTERM, or a terminal that was closed."""
TERMINATION_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)
"""The signals that ask a program to end, as far as this system has them."""
_STDERR = 2


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


def ignore() -> None:
    """Ignore the termination signals from now on: all is done, and the exit status stays what it is."""
    for number in TERMINATION_SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def _takes_text(descriptor: int) -> bool:
    """Whether writing to it does not block, as to a terminal that is stopped or a pipe that is full."""
    return sys.platform == "win32" or bool(select.select([], [descriptor], [], 0)[1])
