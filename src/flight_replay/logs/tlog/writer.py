"""A telemetry log of a replay: what the vehicle sent and what we sent, as ground stations keep it.

Each frame follows an 8-byte stamp: microseconds since 1970, big endian.
"""

from __future__ import annotations

import struct
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import IO

from flight_replay.exceptions import FlightReplayError, VehicleError
from flight_replay.writing.background import Background
from flight_replay.writing.counted import counted
from flight_replay.writing.output_files import NewFile

QUEUED_FRAMES = 20_000
"""Frames that wait for a slow disk: half a minute of a simulator at twenty times speed."""
_CLOSE_S = 5.0


class Recorder:
    """Writes frames to a ``.tlog`` from any thread, whole and in the order of their stamps.

    ``write`` never waits: a thread of its own writes to a new file beside ``path``, which takes the
    place of ``path`` when the recorder is closed. Until then it is there to see, as a program that is killed
    leaves it, with all that was recorded; it stays where ``path`` cannot be replaced. Something that is
    no file, such as a named pipe, is written to directly.
    """

    problem: str | None = None
    """Why frames are missing, in one sentence: a disk that is full must not end a flight."""

    def __init__(self, path: Path, clock_s: Callable[[], float] = time.time) -> None:
        """Create the file, so that a path that cannot be written fails before anything flies.

        Raises:
            VehicleError: The file cannot be written.
        """
        self._path, self._clock_s = path, clock_s
        self._lock = threading.Lock()
        self._last_us = 0
        self._closed = False
        self._new: NewFile | None = None
        self._file: IO[bytes] | None = None
        if not path.exists() or path.is_file() or path.is_dir():
            try:
                self._new = NewFile(path, hidden=False)
            except FlightReplayError as error:
                raise VehicleError(f"cannot record: {error}") from error
            self._file = self._new.file
        self._thread = Background("recorder", QUEUED_FRAMES)

    def write(self, frame: bytes) -> None:
        """Append one frame, stamped now; clocks that are set back do not turn the order round."""
        with self._lock:
            if self._closed:
                return
            self._last_us = max(self._last_us, int(self._clock_s() * 1e6))
            record = struct.pack(">Q", self._last_us) + frame
            self._thread.submit(lambda: self._append(record))

    def _append(self, record: bytes) -> None:
        """Write, on the recorder's thread."""
        if self.problem is not None:
            return
        try:
            if self._file is None:
                self._file = self._path.open("wb")
            self._file.write(record)
            self._file.flush()
        except Exception as error:
            self._fail(getattr(error, "strerror", None) or str(error))

    def _fail(self, reason: str) -> None:
        self.problem = f"recording {self._path} is incomplete: {reason}"

    def close(self) -> None:
        """Finish the file; frames that come later are left out."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        if not self._thread.close(_CLOSE_S, self._finish):
            self._fail(f"it could not be written in {_CLOSE_S:.0f} s")
        elif self._thread.dropped and self.problem is None:
            self._fail(f"{counted(self._thread.dropped, 'frame')} came faster than could be written")

    def _finish(self) -> None:
        """Put the file in its place, on the recorder's thread."""
        try:
            if self._file is not None:
                self._file.close()
        except OSError as error:
            self._fail(error.strerror or str(error))
        if self._new is None:
            return
        try:
            self._new.put_in_place()
        except OSError as error:
            reason = error.strerror or error
            self.problem = f"recording {self._path} cannot have its name: {reason}; it is {self._new.path}"

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
