"""Rows that are not in the table yet: a line of JSON each, whole after a crash but perhaps the last one."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from flight_replay.exceptions import FlightReplayError
from flight_replay.output.many.flight_columns import Row

_SYNC_S = 1.0


class Journal:
    """The file beside a table that takes each row at once; who has it open keeps others from writing."""

    def __init__(self, path: Path) -> None:
        """Open it, and cut off a line that a crash left torn.

        Raises:
            FlightReplayError: Another run has it open, or it cannot be written.
        """
        self._path = path
        self._synced_s = 0.0
        try:
            self._file = _locked(path)
        except BlockingIOError:
            raise FlightReplayError(
                f"another run is writing beside {path}; wait for its end, or name another --out"
            ) from None
        except OSError as error:
            raise FlightReplayError(
                f"cannot write {path}: {error.strerror}; choose another folder"
            ) from error
        self._cut_torn_line()

    def _cut_torn_line(self) -> None:
        self._file.seek(0)
        whole = 0
        for line in self._file:
            if not line.endswith(b"\n"):
                break
            whole += len(line)
        self._file.truncate(whole)
        self._file.seek(whole)

    def append(self, row: Row) -> None:
        """Write a row; it is safe from a crash of this program at once, from one of the machine in a second.

        Raises:
            FlightReplayError: The disk is full.
        """
        try:
            self._file.write(json.dumps(dict(row)).encode() + b"\n")
            self._file.flush()
            if time.monotonic() - self._synced_s > _SYNC_S:
                os.fsync(self._file.fileno())
                self._synced_s = time.monotonic()
        except OSError as error:
            raise FlightReplayError(
                f"cannot write {self._path}: {error.strerror}; free some space, and start again to go on"
            ) from error

    def rows(self) -> Iterator[Row]:
        """The rows in it, in the order in which they came."""
        self._file.seek(0)
        for line in self._file:
            yield json.loads(line)
        self._file.seek(0, os.SEEK_END)

    def clear(self) -> None:
        """Forget all rows: they are in the table."""
        self._file.seek(0)
        self._file.truncate()

    def close(self, *, remove: bool) -> None:
        """Close it, and remove it where nothing is left in it."""
        if remove:
            self._path.unlink(missing_ok=True)
        self._file.close()


def _locked(path: Path) -> BinaryIO:
    """The file, open for this process alone."""
    while True:
        file = open(path, "a+b")  # noqa: SIM115, PTH123 - closed by close
        try:
            _lock(file)
            if os.fstat(file.fileno()).st_ino == path.stat().st_ino:
                return file
        except FileNotFoundError:
            pass  # who had it before removed it just now
        except BaseException:
            file.close()
            raise
        file.close()


def _lock(file: BinaryIO) -> None:
    """Lock a file until it is closed, where the system can.

    Raises:
        BlockingIOError: Another process has locked it.
    """
    try:
        import fcntl
    except ImportError:  # Windows
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except OSError:  # a file system without locks
        return
