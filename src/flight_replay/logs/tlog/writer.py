"""A telemetry log of a replay: what the vehicle sent and what we sent, as ground stations keep it.

Each frame follows an 8-byte stamp: microseconds since 1970, big endian.
"""

from __future__ import annotations

import struct
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import TracebackType

from flight_replay.errors import VehicleError


class Recorder:
    """Writes frames to a ``.tlog`` from any thread, whole and in the order of their stamps."""

    def __init__(self, path: Path, clock_s: Callable[[], float] = time.time) -> None:
        """Create the file, so that a path that cannot be written fails before anything flies.

        Raises:
            VehicleError: The file cannot be written.
        """
        self.problem: str | None = None
        """Why frames are missing, in one sentence: a disk that is full must not end a flight."""
        self._path, self._clock_s = path, clock_s
        self._lock = threading.Lock()
        self._last_us = 0
        try:
            self._file = path.open("wb")
        except OSError as error:
            raise VehicleError(
                f"cannot record to {path}: {error.strerror}; choose another --record file"
            ) from error

    def write(self, frame: bytes) -> None:
        """Append one frame, stamped now; clocks that are set back do not turn the order round."""
        with self._lock:
            if self._file.closed:
                return
            self._last_us = max(self._last_us, int(self._clock_s() * 1e6))
            try:
                self._file.write(struct.pack(">Q", self._last_us) + frame)
            except OSError as error:
                self._close_broken(error)

    def close(self) -> None:
        """Finish the file; frames that come later are left out."""
        with self._lock:
            try:
                self._file.close()
            except OSError as error:
                self._close_broken(error)

    def _close_broken(self, error: OSError) -> None:
        self.problem = f"the recording {self._path} is incomplete: {error.strerror}; make room for the next"
        with suppress(OSError):
            self._file.close()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
