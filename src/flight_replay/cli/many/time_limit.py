"""A limit of wall-clock time that also ends code that does not return: the worker's process ends.

Dask starts another one, tries the flight once more, and then gives it up.
"""

from __future__ import annotations

import faulthandler
import os
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache

_TOLD_S = 1.0
_GRACE_S = 5.0
_STATUS = 75  # EX_TEMPFAIL


@contextmanager
def limited_to(limit_s: float, tell: Callable[[], None]) -> Iterator[None]:
    """End this process if the block takes longer than ``limit_s``, after a call of ``tell``."""
    timer = threading.Timer(limit_s, _end, [tell])
    timer.daemon = True
    timer.start()
    # Code that holds Python's lock keeps the timer from running; this thread does without the lock.
    faulthandler.dump_traceback_later(limit_s + _GRACE_S, exit=True, file=_nowhere())
    try:
        yield
    finally:
        timer.cancel()
        faulthandler.cancel_dump_traceback_later()


def _end(tell: Callable[[], None]) -> None:
    try:
        tell()
        time.sleep(_TOLD_S)  # another thread sends it
    finally:
        os._exit(_STATUS)


@cache
def _nowhere() -> int:
    """A descriptor, open as long as the process."""
    return os.open(os.devnull, os.O_WRONLY)
