"""Saves the mission on board before a replay overwrites it, and restores it.

``python -m flight_replay.cli.restore FILE CONNECTION [BAUD]`` uploads a saved mission to the vehicle.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from datetime import datetime
from itertools import chain, count
from pathlib import Path
from typing import Protocol

from flight_replay.errors import FlightReplayError
from flight_replay.mission import formats
from flight_replay.mission.items import Mission
from flight_replay.output.console.terminal import write_error, write_line

USAGE = "usage: python -m flight_replay.cli.restore FILE CONNECTION [BAUD]"


class HasMissionOnBoard(Protocol):
    """A vehicle whose mission can be read."""

    def mission_on_board(self) -> Mission:
        """The mission that is on board now."""


def save_mission_on_board(vehicle: HasMissionOnBoard, folder: Path, now: datetime) -> Path | None:
    """Save the mission on board to a new ``.waypoints`` file; None if there is no mission.

    Raises:
        FlightReplayError: The mission cannot be read or written.
    """
    mission = vehicle.mission_on_board()
    if not mission.items:
        return None
    path = _unused(folder / f"mission-before-{now:%Y%m%d-%H%M%S}.waypoints")
    formats.save(path, mission)
    return path


def _unused(path: Path) -> Path:
    """The path, or a numbered one: missions of several vehicles may be saved in the same second."""
    numbered = (path.with_stem(f"{path.stem}-{number}") for number in count(2))
    return next(other for other in chain([path], numbered) if not other.exists())


def restore_command(path: Path, connection: str, baud: int) -> str:
    """The shell command that restores a saved mission."""
    speed = [str(baud)] if ":" not in connection else []
    return shlex.join(["python", "-m", "flight_replay.cli.restore", str(path), connection, *speed])


def main(arguments: Sequence[str]) -> int:
    """Upload a saved mission; returns the exit status."""
    if len(arguments) not in (2, 3) or (len(arguments) == 3 and not arguments[2].isdigit()):
        sys.stderr.write(USAGE + "\n")
        return 2
    from flight_replay import vehicle

    try:
        mission = formats.load_mission(Path(arguments[0]))
        baud = int(arguments[2]) if len(arguments) == 3 else 57600
        with vehicle.connect(arguments[1], baud=baud) as connected:
            connected.upload(mission)
    except FlightReplayError as error:
        write_error(sys.stderr, str(error))
        return 1
    write_line(sys.stdout, f"Restored {len(mission.items)} mission items from {arguments[0]}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
