"""Text of others, made safe to print: a terminal does what the control characters in it say.

Autopilots, servers, logs and file names may hold any characters. Some move the cursor, change colours or
titles, or reverse the order of what follows, so that a person reads something else than was written.
"""

from __future__ import annotations

import argparse
import difflib
import sys
from typing import TYPE_CHECKING, NoReturn

if TYPE_CHECKING:
    from _typeshed import SupportsWrite


_ALIKE = 0.7
"""Of 1; below it are other words, such as --quiet and --wait."""


def escaped(text: str) -> str:
    r"""The text with Python escapes, such as ``\x1b``, for all but printable characters and the blank.

    Escaped are control characters (C0, DEL and C1, newlines too), those that change the direction of
    writing, those without width, and lone surrogates.
    """
    if text.isprintable():
        return text
    return "".join(each if each.isprintable() else repr(each)[1:-1] for each in text)


class Parser(argparse.ArgumentParser):
    """A parser of a command line whose errors are one line and a hint, with what was typed escaped."""

    _unwritten: OSError | None = None

    def error(self, message: str) -> NoReturn:
        """Write what is wrong, and what may have been meant, to stderr; exit with status 2."""
        hint = self._meant(message) or f"see {self.prog} --help"
        self.exit(2, f"{self.prog}: error: {escaped(message)}; {escaped(hint)}\n")

    def _print_message(self, message: str, file: SupportsWrite[str] | None = None) -> None:
        """Write help, usage or an error; ``exit`` tells what could not be written, which argparse ignores."""
        try:
            (file or sys.stderr).write(message)
        except OSError as error:
            self._unwritten = error

    def exit(self, status: int = 0, message: str | None = None) -> NoReturn:
        """End the program; a reader that has exited (``| head``) is no failure."""
        unwritten, self._unwritten = self._unwritten, None
        if unwritten is not None and not isinstance(unwritten, BrokenPipeError):
            why = f"cannot write stdout: {unwritten.strerror}; free some space, or write elsewhere"
            super().exit(1, f"{self.prog}: error: {why}\n")
        super().exit(status, message)

    def _meant(self, message: str) -> str | None:
        """The option that is most like one that does not exist, or what a second file name comes of."""
        unknown = message.removeprefix("unrecognized arguments: ").split("=")[0].split()
        if not message.startswith("unrecognized"):
            return None
        if not unknown[0].startswith("-") and self._get_positional_actions():
            return "name one file, in quotes if there are spaces in its name"
        if not unknown[0].startswith("--"):
            return None
        close = difflib.get_close_matches(unknown[0], self._option_string_actions, 1, _ALIKE)
        return f"did you mean {close[0]}?" if close else None
