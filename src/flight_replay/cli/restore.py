"""Saves the mission on board before a replay overwrites it, and restores it.

``python -m flight_replay.cli.restore FILE CONNECTION [BAUD]`` uploads a saved mission to the vehicle, or sets
the parameters that a replay which was killed did not put back.
"""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Protocol

from flight_replay import signals
from flight_replay.cli import option_types
from flight_replay.cli.kept_parameters import SUFFIXES, read_parameter_file
from flight_replay.events import Event, Notice
from flight_replay.exceptions import FlightReplayError
from flight_replay.mission import formats
from flight_replay.mission.items import Mission
from flight_replay.output.console.terminal import flush_or_discard, write_error, write_line
from flight_replay.simulator.server.addresses import is_serial_port
from flight_replay.writing.counted import counted
from flight_replay.writing.output_files import unused_path
from flight_replay.writing.terminal_text import Parser


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
    path = unused_path(folder / f"mission-before-{now:%Y%m%d-%H%M%S}.waypoints")
    formats.save(path, mission)
    return path


def restore_command(path: Path, connection: str, baud: int, signing_key: Path | None = None) -> str:
    """The shell command that restores a saved mission, or parameters."""
    speed = [str(baud)] if is_serial_port(connection) else []
    signing = ["--signing-key", str(signing_key)] if signing_key else []
    return shlex.join(["python", "-m", "flight_replay.cli.restore", *signing, str(path), connection, *speed])


def main(arguments: Sequence[str]) -> int:
    """Upload a saved mission, or set parameters; returns the exit status, 1 if any is not confirmed."""
    try:
        options = _parser().parse_args(arguments)
    except SystemExit as stop:
        return int(stop.code or 0)
    try:
        restored, unset = _restore(options)
        if restored:
            write_line(sys.stdout, f"Restored {restored} from {options.file}")
        problem = "; ".join(filter(None, [unset, flush_or_discard(sys.stdout)])) or None
    except FlightReplayError as error:
        problem = str(error)
    except KeyboardInterrupt:
        write_error(sys.stderr, "interrupted; what is on board may be incomplete")
        return signals.INTERRUPTED_STATUS
    if problem is not None:
        write_error(sys.stderr, problem)
        flush_or_discard(sys.stderr)
    return 0 if problem is None else 1


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="python -m flight_replay.cli.restore",
        description="Upload a mission that was saved before a replay, or put parameters (.parm) back.",
        allow_abbrev=False,
    )
    parser.add_argument(
        "file", metavar="FILE", type=Path, help="mission-before-….waypoints or parameters-before-….parm"
    )
    parser.add_argument("connection", metavar="CONNECTION", help="as for flight-replay --connect")
    parser.add_argument(
        "baud",
        metavar="BAUD",
        nargs="?",
        type=option_types.baud,
        default=57600,
        help="baud rate of a serial port (default: 57600)",
    )
    parser.add_argument("--signing-key", metavar="FILE", type=Path, help="as for flight-replay")
    return parser


def _restore(options: argparse.Namespace) -> tuple[str, str]:
    """Restore what the file holds; what the vehicle confirmed of it, and the problem with the rest."""
    from flight_replay import vehicle

    def show_notice(event: Event) -> None:
        if isinstance(event, Notice):
            write_line(sys.stderr, event.text)

    parameters = read_parameter_file(options.file) if options.file.suffix in SUFFIXES else None
    mission = formats.load_mission(options.file) if parameters is None else Mission(())
    with vehicle.connect(
        options.connection, baud=options.baud, listener=show_notice, signing_key=options.signing_key
    ) as connected:
        if parameters is None:
            connected.upload(mission)
            return counted(len(mission.items), "mission item"), ""
        unset = connected.set_known_parameters(parameters)
    return ", ".join(name for name in parameters if name not in unset), _not_restored(unset)


def _not_restored(unset: Mapping[str, str]) -> str:
    """The problem with parameters that a vehicle did not confirm, for the reasons given."""
    if not unset:
        return ""
    names = ", ".join(f"{name} ({why})" for name, why in unset.items())
    return f"not restored: {names}; check the link and run this again, or set it with a ground station"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
