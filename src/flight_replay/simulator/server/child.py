"""The simulator as a process of its own, for ``launch``: reads settings from stdin, writes its addresses.

It ends when stdin is closed, so it never outlives the program that started it. Run as
``python -m flight_replay.simulator.server.child``.
"""

from __future__ import annotations

import contextlib
import json
import signal
import sys
import threading

from flight_replay.exceptions import SimulatorError
from flight_replay.simulator.server.settings import open_endpoint, settings_of


def main() -> int:
    """Read the settings, write the addresses or an error, then run until stdin is closed."""
    # Ctrl-C in a terminal reaches the whole process group; the program that started this one ends it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    line = sys.stdin.readline()
    if not line.endswith("\n"):
        return 1  # The program that started this one has ended.
    try:
        endpoint = open_endpoint(settings_of(line))
    except SimulatorError as error:
        _answer({"error": str(error)})
        return 1
    over = threading.Event()
    threading.Thread(target=_wait_for_end, args=(over,), daemon=True).start()
    try:
        _answer({"addresses": [str(address) for address in endpoint.addresses]})
        endpoint.run(over.is_set)
    finally:
        endpoint.close()
    return 0


def _wait_for_end(over: threading.Event) -> None:
    sys.stdin.read()
    over.set()


def _answer(value: dict[str, object]) -> None:
    """Write one line; where nobody reads it any more, standard input is closed too."""
    try:
        sys.stdout.write(json.dumps(value) + "\n")
        sys.stdout.flush()
    except OSError:
        with contextlib.suppress(OSError):
            sys.stdout.close()  # Otherwise Python would flush it once more, and show that error.


if __name__ == "__main__":
    sys.exit(main())
