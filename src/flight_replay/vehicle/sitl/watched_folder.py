"""A temporary folder for a simulator; both are gone once this program is, however it ends."""

from __future__ import annotations

import secrets
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from flight_replay.vehicle.sitl import watcher

_WATCHER_ENDS_S = 3.0


class WatchedFolder:
    """A folder, and the processes that run in it; a watcher removes both if this program cannot."""

    def __init__(self) -> None:
        self.path = Path(tempfile.gettempdir(), f"flight-replay-sitl-{secrets.token_hex(8)}").resolve()

    def __enter__(self) -> WatchedFolder:
        """Start the watcher before there is anything to remove."""
        self._watcher = subprocess.Popen(
            # Isolated and without site-packages it starts in a fifth of the time.
            [sys.executable, "-I", "-S", watcher.__file__, str(self.path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            text=True,
            # No signal from the terminal reaches it.
            start_new_session=True,
        )
        self.path.mkdir(mode=0o700)
        return self

    def __exit__(self, *_: object) -> None:
        """Remove the folder, and wait for the watcher to make sure of it."""
        shutil.rmtree(self.path, ignore_errors=True)
        assert self._watcher.stdin is not None
        with suppress(OSError):
            self._watcher.stdin.close()
        with suppress(subprocess.TimeoutExpired):
            self._watcher.wait(_WATCHER_ENDS_S)

    def spawn(self, command: Sequence[Path | str], log: Path) -> subprocess.Popen[bytes]:
        """Start a process in the folder, in a session of its own, with its output in a file."""
        with log.open("wb") as output:
            process = subprocess.Popen(
                command,
                cwd=self.path,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                # Ctrl-C at the terminal must not end the simulator: the copter has to fly RTL first.
                start_new_session=True,
            )
        self._tell(f"+{process.pid}")
        return process

    def forget(self, process: subprocess.Popen[bytes]) -> None:
        """The process has ended: another one may get its number."""
        self._tell(f"-{process.pid}")

    def _tell(self, line: str) -> None:
        assert self._watcher.stdin is not None
        with suppress(OSError):
            self._watcher.stdin.write(line + "\n")
            self._watcher.stdin.flush()
