"""The confirmation that a person types before a real vehicle is armed."""

from __future__ import annotations

import sys
from contextlib import suppress

from flight_replay.errors import VehicleError
from flight_replay.output.console.console import Console

CONSENT_WORD = "fly"


def ask_consent(console: Console) -> None:
    """Ask at the terminal whether to arm the vehicle.

    Raises:
        VehicleError: Standard input is not a terminal, or the answer was not ``CONSENT_WORD``.
    """
    if not sys.stdin.isatty():
        raise VehicleError("not armed: there is no terminal to ask for confirmation; use --yes")
    with console.paused():
        sys.stderr.write(f"The motors will start. Stand clear, then type '{CONSENT_WORD}' to arm: ")
        sys.stderr.flush()
        answer = ""
        with suppress(OSError):  # The terminal was closed.
            answer = sys.stdin.readline()
    if answer.strip().lower() != CONSENT_WORD:
        raise VehicleError(f"not armed: '{CONSENT_WORD}' was not typed")
