"""Streams for the tests of the console."""

import io


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


class ClosedPipe(io.StringIO):
    """A pipe whose reader has exited."""

    def write(self, text: str) -> int:
        raise BrokenPipeError
