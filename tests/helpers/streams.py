"""Streams for the tests of the console."""

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


class ClosedPipe(io.StringIO):
    """A pipe whose reader has exited."""

    def write(self, text: str) -> int:
        raise BrokenPipeError


@contextmanager
def full_pipe() -> Iterator[int]:
    """The end of a pipe to write to, which is full and which nobody reads."""
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    with suppress(BlockingIOError):
        while True:
            os.write(writer, b"x" * 4096)
    os.set_blocking(writer, True)
    try:
        yield writer
    finally:
        os.close(reader)
        os.close(writer)
