"""The command line's options: one table for parsing and help, and plain data for everybody else."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from flight_replay.cli.option_groups import add_groups
from flight_replay.planning.altitude import Recorded

_EXAMPLES = """\
examples:
  flight-replay                                    fly ./flight.tlog, or the sample flight, in a simulator
  flight-replay --tlog flight.tlog --speedup 10    the same of your own log, ten times faster
  flight-replay --connect 127.0.0.1:14550          on the vehicle that sends to this UDP port
  flight-replay --route fit --duration all --speed recorded
                                                   the whole flight, at the speed it was flown
  flight-replay --dry-run --save mission.waypoints only plan, and keep the mission
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """What the user asked for; lengths in metres, times in seconds, speeds in m/s."""

    tlog: str | None
    vehicle: tuple[int, int | None] | None
    flight: int | None
    from_s: float | None
    to_s: float | None
    route: Literal["spacing", "fit"]
    spacing_m: float
    max_points: int
    altitude_m: float | Recorded
    speed_m_s: float | Recorded | None
    duration_s: float | None
    limits: Literal["vehicle", "recorded"]
    takeoff_altitude_m: float
    land: bool
    max_distance_m: float
    yes: bool
    connect: str | None
    baud: int
    sim: Literal["auto", "sitl", "builtin"]
    sitl: Path | None
    speedup: float | None
    dry_run: bool
    json: bool
    save: tuple[Path, ...]
    record: Path | None
    plot: Path | None
    report: Path | None
    gcs: tuple[str, ...]
    map: bool
    verbose: bool
    quiet: bool


def parse(argv: Sequence[str] | None = None) -> Options:
    """Options from the command line.

    Raises:
        SystemExit: 2 on wrong usage; 0 after ``--help`` and ``--version``.
    """
    parser = build_parser()
    values = vars(parser.parse_args(argv))
    _check_together(parser, values)
    values["sim"] = values["sim"] or ("sitl" if values["sitl"] else "auto")
    values["save"] = tuple(values["save"] or ())
    values["gcs"] = tuple(values["gcs"] or ())
    return Options(**values)


def build_parser() -> argparse.ArgumentParser:
    """The parser of ``flight-replay``, its options in the groups of the manual."""
    parser = argparse.ArgumentParser(
        prog="flight-replay",
        description="Fly a recorded drone flight again: from a MAVLink telemetry log (.tlog) to a waypoint\n"
        "mission, to a simulator or a real vehicle, and home.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
        add_help=False,
    )
    # Of an option outside a group argparse makes a trial help text, whose imports take longer than parsing.
    group = parser.add_argument_group("options")
    group.add_argument("-h", "--help", action="help", help="show this help message and exit")
    add_groups(parser)
    return parser


def _check_together(parser: argparse.ArgumentParser, values: dict[str, object]) -> None:
    """Refuse options that contradict each other."""
    if values["connect"] is not None and (values["sim"] or values["sitl"]):
        parser.error("--connect names a vehicle: leave out --sim and --sitl")
    if values["sitl"] and values["sim"] == "builtin":
        parser.error("--sitl names an ArduPilot binary: leave out --sim builtin")
    if values["verbose"] and values["quiet"]:
        parser.error("-v and -q ask for opposite things: leave out one")
    begin, end = values["from_s"], values["to_s"]
    if isinstance(begin, float) and isinstance(end, float) and begin >= end:
        parser.error(f"--from {begin:g} is not before --to {end:g}")
