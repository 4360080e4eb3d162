"""The confirmation that a person types before a real vehicle is armed."""

from __future__ import annotations

import sys
import time
from contextlib import suppress

from flight_replay.exceptions import VehicleError
from flight_replay.output.console.console import Console

CONSENT_WORD = "fly"
_SHOWN_WITHIN_S = 10.0
_READ_S = 1.0
"""Least time for which the briefing is on the screen before the word is asked for."""


def ask_consent(console: Console) -> None:
    """Ask at the terminal whether to arm the vehicle.

    Raises:
        VehicleError: Standard input is not a terminal, or the answer was not ``CONSENT_WORD``.
    """
    if not sys.stdin.isatty():
        raise VehicleError("not armed: there is no terminal to ask for confirmation; use --yes")
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
