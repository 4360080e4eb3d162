"""Work that must not hold up a flight: done in order by a thread, from a bounded queue that drops and counts.

A terminal that is stopped, a pipe that nobody reads or a full disk can block a write for ever. Whoever
watches a flight therefore only submits; nothing here blocks the submitting thread.
"""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable

_log = logging.getLogger(__name__)

Call = Callable[[], object]


class Background:
    """A daemon thread that makes the calls that are submitted; an exception of one is logged."""

    def __init__(self, name: str, capacity: int) -> None:
        """At most ``capacity`` calls wait."""
        self.dropped = 0
        """How many calls did not fit."""
        self._capacity = capacity
        self._calls: queue.SimpleQueue[Call | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name=f"flight-replay {name}", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while (call := self._calls.get()) is not None:
            try:
                call()
            except Exception:
                _log.exception("%s goes on after an error", self._thread.name)

    def submit(self, call: Call) -> bool:
        """Have ``call`` made soon; False if it was dropped, because too many wait. Never blocks."""
        if self._calls.qsize() >= self._capacity:
            self.dropped += 1
            return False
        self._calls.put(call)
        return True

    def wait(self, timeout_s: float | None) -> bool:
        """Wait until all that was submitted is done; False if the time ran out first."""
        done = threading.Event()
        self._calls.put(done.set)
        return done.wait(timeout_s)

    def close(self, timeout_s: float | None, last: Call | None = None) -> bool:
        """End the thread once all is done; False if the time ran out first, and the thread is left behind.

        ``last`` is made after all else, however many calls wait.
        """
        if last is not None:
            self._calls.put(last)
        self._calls.put(None)
        self._thread.join(timeout_s)
        return not self._thread.is_alive()
