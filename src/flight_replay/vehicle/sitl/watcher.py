"""The process that watches over a simulator: run by its path, it imports nothing but the standard library.

Its one argument is the simulator's folder. Its standard input is a pipe from the program that started the
simulator, with a line ``+PID`` or ``-PID`` for each process that was started there or has ended. The pipe
closes when that program ends, also when it is killed: then what is left of the simulator is removed.
"""

from __future__ import annotations

import os
import shutil
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

_KILL = getattr(signal, "SIGKILL", signal.SIGTERM)
_TRIES, _BETWEEN_S = 20, 0.05


def main() -> None:
    """Wait for the end of the program, then remove the simulator and its folder."""
    folder = Path(sys.argv[1])
    groups: set[int] = set()
    for line in sys.stdin:
        if line.startswith("+"):
            groups.add(int(line))
        else:
            groups.discard(-int(line))
    for group in groups:
        _kill_group(group)
    for _ in range(_TRIES):
        # A process that was just started has not changed to the folder yet, and cannot once it is gone.
        shutil.rmtree(folder, ignore_errors=True)
        for process_id in _running_in(folder):
            with suppress(OSError):
                os.kill(process_id, _KILL)
        if not folder.exists():
            return
        time.sleep(_BETWEEN_S)


def _kill_group(group: int) -> None:
    with suppress(OSError):
        if hasattr(os, "killpg"):
            os.killpg(group, _KILL)
        else:
            os.kill(group, _KILL)


def _running_in(folder: Path) -> Iterator[int]:
    """The processes whose current folder it is or was, where the system tells (Linux)."""
    for link in Path("/proc").glob("[0-9]*/cwd"):
        with suppress(OSError):
            if str(link.readlink()).removesuffix(" (deleted)") == str(folder):
                yield int(link.parent.name)


if __name__ == "__main__":
    main()
