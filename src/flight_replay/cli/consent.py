"""The confirmation that a person types before a real vehicle is armed."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress

from flight_replay.events import VehicleState
from flight_replay.exceptions import VehicleError
from flight_replay.output.console.console import Console

CONSENT_WORD = "fly"
CONSENT_S = 10.0
"""A word that is older does not arm: whoever typed it may be at the vehicle by now."""
_SHOWN_WITHIN_S = 10.0
_READ_S = 1.0
"""Least time for which the briefing is on the screen before the word is asked for."""


class ArmingConsent:
    """Consent to arm a real vehicle: the word, or ``--yes``. It lapses if the vehicle is not armed soon."""

    def __init__(
        self,
        console: Console,
        briefing: Callable[[VehicleState], Sequence[str]],
        *,
        asks: bool,
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        """``briefing`` checks the vehicle where it is and describes it; without ``asks`` it was just shown.

        Raises:
            VehicleError: There is no terminal to ask at.
        """
        if asks:
            _check_terminal()
        self._console, self._briefing, self._asks, self._clock_s = console, briefing, asks, clock_s
        self._given_s = float("-inf") if asks else clock_s()

    def __call__(self, next_state: Callable[[], VehicleState]) -> bool:
        """Before a request to arm: whether a person had to be asked. ``next_state`` reads the position.

        Raises:
            FlightReplayError: There is no consent, or the vehicle must not be flown from where it is now.
        """
        age_s = self._clock_s() - self._given_s
        if age_s <= CONSENT_S:
            return False
        lines = self._briefing(next_state())
        if self._asks:
            if age_s < float("inf"):
                self._console.print(
                    f"The word counts for {CONSENT_S:.0f} s only, and the vehicle is not armed."
                )
            for line in lines:
                self._console.print(line)
            ask_consent(self._console)
        else:
            self._console.print("The motors will start, without a question (--yes). Stand clear.")
        self._given_s = self._clock_s()
        if self._asks:
            self._briefing(next_state())  # Meanwhile the vehicle may have been moved.
        return self._asks


def _check_terminal() -> None:
    if not sys.stdin.isatty():
        raise VehicleError("not armed: there is no terminal to ask for confirmation; use --yes")


def ask_consent(console: Console) -> None:
    """Ask at the terminal whether to arm the vehicle.

    Raises:
        VehicleError: Standard input is not a terminal, or the answer was not ``CONSENT_WORD``.
    """
    _check_terminal()
    if not console.flush(_SHOWN_WITHIN_S):
        raise VehicleError("not armed: the terminal does not show the vehicle and the route; try again")
    with console.paused():
        time.sleep(_READ_S)
        _discard_typed_input()
        sys.stderr.write(f"The motors will start. Stand clear, then type '{CONSENT_WORD}' to arm: ")
        sys.stderr.flush()
        answer = ""
        with suppress(OSError):  # The terminal was closed.
            answer = sys.stdin.readline()
    if answer.strip().lower() != CONSENT_WORD:
        raise VehicleError(f"not armed: '{CONSENT_WORD}' was not typed")


def _discard_typed_input() -> None:
    """Forget what was typed before the question: it was not an answer to it."""
    try:
        import termios
    except ImportError:
        import msvcrt

        while msvcrt.kbhit():  # type: ignore[attr-defined, unused-ignore]
            msvcrt.getwch()  # type: ignore[attr-defined, unused-ignore]
    else:
        with suppress(OSError, ValueError, termios.error):  # The terminal was closed: there is no answer.
            termios.tcflush(sys.stdin, termios.TCIFLUSH)
