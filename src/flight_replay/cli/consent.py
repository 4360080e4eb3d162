"""The word that a person types before a real vehicle is armed."""

from __future__ import annotations

import sys
from contextlib import suppress

from flight_replay.errors import VehicleError
from flight_replay.output.console.console import Console

WORD = "fly"


def ask_consent(console: Console) -> None:
    """Ask at the terminal whether to arm.

    Raises:
        VehicleError: There is no terminal to ask at, or the answer was not the word.
    """
    if not sys.stdin.isatty():
        raise VehicleError("a real vehicle is only armed with --yes, or at a terminal where it can be asked")
    with console.paused():
        sys.stderr.write(f"Its motors will start. Stand clear, then type {WORD} to arm and fly: ")
        sys.stderr.flush()
        answer = ""
        with suppress(OSError):  # The terminal was closed.
            answer = sys.stdin.readline()
    if answer.strip().lower() != WORD:
        raise VehicleError("the vehicle was not armed, as it was not asked for")
