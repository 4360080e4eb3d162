"""Errors of this program on the link's thread, which goes on after each; and whether it hears anything."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

from flight_replay.exceptions import LinkFaultError, failure_text

_log = logging.getLogger(__name__)

_MANY, _LASTING_S = 3, 1.0


class LinkFaults:
    """Notes faults on the link's thread, and whether messages of the vehicle pass between them."""

    def __init__(self, clock_s: Callable[[], float] = time.monotonic) -> None:
        """``clock_s`` is wall-clock time."""
        self.first = ""
        """The first fault, in a sentence; empty without one."""
        self._clock_s = clock_s
        self._in_a_row, self._since_s, self._latest = 0, 0.0, ""
        self._logged: set[tuple[str, type[BaseException]]] = set()

    def note(self, what: str, error: BaseException, *, unheard: bool = True) -> None:
        """Note that the program cannot do something because of an error, which is logged once.

        ``unheard`` is whether a message of the vehicle may be lost by it.
        """
        if (what, type(error)) not in self._logged:
            self._logged.add((what, type(error)))
            _log.error("cannot %s", what, exc_info=error)
        told = f"cannot {what}: {failure_text(error)}"
        self.first = self.first or told
        if unheard:
            self._latest = told
            self._since_s = self._since_s if self._in_a_row else self._clock_s()
            self._in_a_row += 1

    def passed(self) -> None:
        """A message of the vehicle was received by all who need it."""
        self._in_a_row = 0

    def check(self) -> None:
        """Check that the vehicle is heard, in spite of faults.

        Raises:
            LinkFaultError: For a second and several faults it was not.
        """
        if self._in_a_row >= _MANY and self._clock_s() - self._since_s >= _LASTING_S:
            raise LinkFaultError(f"nothing is heard from the vehicle: {self._latest}")
