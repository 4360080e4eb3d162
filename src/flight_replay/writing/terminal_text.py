"""Text of others, made safe to print: a terminal does what the control characters in it say.

Autopilots, servers, logs and file names may hold any characters. Some move the cursor, change colours or
titles, or reverse the order of what follows, so that a person reads something else than was written.
"""

from __future__ import annotations

import argparse
from typing import NoReturn


def escaped(text: str) -> str:
    r"""The text with Python escapes, such as ``\x1b``, for all but printable characters and the blank.

    Escaped are control characters (C0, DEL and C1, newlines too), those that change the direction of
    writing, those without width, and lone surrogates.
    """
    if text.isprintable():
        return text
    return "".join(each if each.isprintable() else repr(each)[1:-1] for each in text)


class Parser(argparse.ArgumentParser):
    """A parser of a command line whose errors repeat what was typed, escaped."""

    def error(self, message: str) -> NoReturn:
        """Write usage and message to stderr, and exit with status 2."""
        super().error(escaped(message))
