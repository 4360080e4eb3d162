"""Fly the flights of some logs on two ArduCopter builds, and say what the new one flies worse.

    python examples/two_firmwares.py OLD_SITL NEW_SITL PATH...

OLD_SITL and NEW_SITL are ArduPilot SITL binaries, PATHs are logs or folders. The exit status is 1 if a flight
became worse. Needs: pip install "flight-replay[many]"
"""

import sys
from pathlib import Path

from flight_replay.cli.many.many_main import main

REPLAY = ["--fly", "sitl", "--speedup", "10", "--route", "fit", "--duration", "all", "--speed", "recorded"]


def fly(sitl: str, table: str, logs: list[str]) -> None:
    """Fly all flights on a binary; what the table holds already is not flown again."""
    print(f"{sitl}: the table is {table}")
    status = main([*logs, *REPLAY, "--sitl", sitl, "--out", table])
    if status:
        sys.exit(status)


if __name__ == "__main__":
    if len(sys.argv) < 4 or not all(Path(each).is_file() for each in sys.argv[1:3]):
        sys.exit("usage: python examples/two_firmwares.py OLD_SITL NEW_SITL PATH...")
    old, new, *paths = sys.argv[1:]
    fly(old, "old.parquet", paths)
    fly(new, "new.parquet", paths)
    sys.exit(main(["--compare", "old.parquet", "new.parquet"]))
