"""background.py: calls are made in order by a thread, and the one who submits never waits."""

from __future__ import annotations

import threading
import time

from flight_replay.writing.background import Background


def test_calls_are_made_in_order_and_errors_end_nothing() -> None:
    """What one call raises does not keep the next from being made."""
    background, made = Background("test", 100), list[int]()

    def fail() -> None:
        raise OSError("full")

    for number in range(10):
        background.submit(fail)
        background.submit(lambda number=number: made.append(number))  # type: ignore[misc]
    assert background.wait(10)
    assert made == list(range(10))
    assert background.close(10)
    assert background.dropped == 0


def test_what_does_not_fit_is_dropped_and_counted() -> None:
    """While a call is stuck, a bounded number waits, and submitting, waiting and closing return."""
    background, free = Background("test", 5), threading.Event()
    background.submit(free.wait)
    began_s = time.monotonic()
    taken = sum(background.submit(lambda: None) for _ in range(1000))
    assert taken <= 6
    assert background.dropped == 1000 - taken
    assert not background.wait(0.05)
    assert not background.close(0.05)
    assert time.monotonic() - began_s < 5
    free.set()
    assert background.close(10)


def test_the_last_call_is_made_however_many_wait() -> None:
    """What ends a file or gives a terminal back is not dropped."""
    background, free, made = Background("test", 5), threading.Event(), list[str]()
    background.submit(free.wait)
    while background.submit(lambda: made.append("waited")):
        pass
    threading.Timer(0.05, free.set).start()
    assert background.close(10, lambda: made.append("last"))
    assert made.count("waited") >= 4
    assert made[-1] == "last"
