"""MAVProxy at its prompt, driven by what it prints."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import threading
import time
from pathlib import Path

DEADLINE_S = 120.0
"""Long enough for a machine with many other programs; a test that passes does not wait for it."""
ARMED_ON_GROUND = {"DISARM_DELAY": 0.0}
"""A copter in quick motion waits for a slow station: ten vehicle seconds may be half a second."""
_SAY_AGAIN_S = 3.0
"""Doubled each time: a command that takes long, such as an upload, starts over when it is typed again."""


class MavProxy:
    """MAVProxy as a process: commands in, lines out."""

    def __init__(self, connection: str, folder: Path) -> None:
        script = Path(sys.executable).with_name("mavproxy.py")
        self._process = subprocess.Popen(
            [sys.executable, str(script), "--master", connection, "--state-basedir", str(folder),
             "--aircraft", "test", "--default-modules", "arm,cmdlong,mode,wp,param",
             "--cmd", "set flushlogs 1"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            cwd=folder, env={**os.environ, "HOME": str(folder), "TERM": "dumb", "PYTHONUNBUFFERED": "1"},
        )  # fmt: skip
        self._lines: list[str] = []
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        self._lines.extend(self._process.stdout)

    def _said(self, pattern: str, since: int) -> bool:
        return any(re.search(pattern, line) for line in self._lines[since:])

    def expect(self, *patterns: str) -> None:
        """Wait until it has said a line for each pattern since it started, in any order."""
        deadline = time.monotonic() + DEADLINE_S
        for pattern in patterns:
            while not self._said(pattern, 0):
                assert time.monotonic() < deadline, f"no {pattern!r} in {self._lines}"
                time.sleep(0.02)

    def say(self, line: str) -> None:
        """Type a line."""
        assert self._process.stdin is not None
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()

    def command(self, line: str, answer: str) -> None:
        """Type a line, again and again, until a line answers it: the vehicle may not be ready."""
        since, deadline = len(self._lines), time.monotonic() + DEADLINE_S
        say_again, wait_s = 0.0, _SAY_AGAIN_S
        while not self._said(answer, since):
            assert time.monotonic() < deadline, f"{line!r} had no {answer!r} in {self._lines}"
            if time.monotonic() >= say_again:
                self.say(line)
                say_again = time.monotonic() + wait_s
                wait_s *= 2
            time.sleep(0.02)

    def close(self) -> None:
        """End MAVProxy."""
        self._process.kill()
        self._process.wait()
        self._reader.join()
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.close()
        self._process.stdout.close()
