"""The options of the command line: the parser, and the parsed values as plain data."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from flight_replay.cli.option_groups import add_groups
from flight_replay.planning.altitude import FLOOR_M, RECORDED, Recorded
from flight_replay.writing.terminal_text import Parser

_EXAMPLES = """\
examples:
  flight-replay
      fly ./flight.tlog, or the sample flight, on a simulator
  flight-replay --tlog flight.tlog --speedup 10
      fly your own log, ten times faster than real time
  flight-replay --connect 127.0.0.1:14550
      fly it on the vehicle that sends to this UDP port
  flight-replay --route fit --duration all --speed recorded
      fly the whole flight at the recorded speed
  flight-replay --dry-run --save mission.waypoints
      plan only, and save the mission
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """The parsed options; lengths in metres, times in seconds, speeds in m/s."""

    tlog: str | None
    vehicle: tuple[int, int | None] | None
    flight: int | None
    from_s: float | None
    to_s: float | None
    mode: Literal["auto", "guided"]
    route: Literal["spacing", "fit"]
    spacing_m: float
    max_points: int
    altitude_m: float | Recorded
    floor_m: float
    raise_m: float
    speed_m_s: float | Recorded | None
    pace: float
    heading: Literal["vehicle", "recorded"]
    max_error_m: float
    duration_s: float | None
    limits: Literal["vehicle", "recorded"]
    takeoff_altitude_m: float
    land: bool
    max_distance_m: float
    yes: bool
    connect: str | None
    baud: int
    signing_key: Path | None
    sim: Literal["auto", "sitl", "builtin"]
    sitl: Path | None
    speedup: float | None
    dry_run: bool
    json: bool
    save: tuple[Path, ...]
    record: Path | None
    plot: Path | None
    report: Path | None
    force: bool
    gcs: tuple[str, ...]
    gcs_open: bool
    map: bool
    verbose: bool
    quiet: bool


def parse_options(argv: Sequence[str] | None = None) -> Options:
    """Parse the command line.

    Raises:
        SystemExit: 2 for wrong usage, 0 after ``--help`` or ``--version``.
    """
    parser = build_parser()
    values = vars(parser.parse_args(argv))
    values["altitude_m"], values["raise_m"] = values["altitude_m"]
    values["speed_m_s"], values["pace"] = values["speed_m_s"]
    _check_combinations(parser, values)
    values["floor_m"] = FLOOR_M if values["floor_m"] is None else values["floor_m"]
    values["sim"] = values["sim"] or ("sitl" if values["sitl"] else "auto")
    values["heading"] = values["heading"] or ("recorded" if values["mode"] == "guided" else "vehicle")
    values["save"] = tuple(values["save"] or ())
    values["gcs"] = tuple(values["gcs"] or ())
    return Options(**values)


def build_parser() -> argparse.ArgumentParser:
    """The parser of ``flight-replay``."""
    parser = Parser(
        prog="flight-replay",
        description="Fly a recorded drone flight again: turn a MAVLink telemetry log (.tlog) into a\n"
        "mission, fly it on a simulator or a real vehicle, and compare the flight with\n"
        "the recording.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
        add_help=False,
    )
    # For an option outside a group argparse formats a help text, which takes longer than parsing.
    group = parser.add_argument_group("options")
    group.add_argument("-h", "--help", action="help", help="show this help message and exit")
    add_groups(parser)
    return parser


def _check_combinations(parser: argparse.ArgumentParser, values: dict[str, object]) -> None:
    """Refuse options that exclude each other."""
    if values["connect"] is not None and (values["sim"] or values["sitl"]):
        parser.error("--sim and --sitl start a simulator and cannot be used with --connect")
    if values["connect"] is None and values["signing_key"]:
        parser.error("--signing-key is for a vehicle given with --connect")
    if values["floor_m"] is not None and values["altitude_m"] != RECORDED:
        parser.error("--floor is for recorded altitudes and needs --altitude recorded")
    _check_mode(parser, values)
    if values["sitl"] and values["sim"] == "builtin":
        parser.error("--sitl starts ArduPilot SITL and cannot be used with --sim builtin")
    if values["verbose"] and values["quiet"]:
        parser.error("-v and -q cannot be used together")
    begin, end = values["from_s"], values["to_s"]
    if isinstance(begin, float) and isinstance(end, float) and begin >= end:
        parser.error(f"--from {begin:g} must be less than --to {end:g}")


def _check_mode(parser: argparse.ArgumentParser, values: dict[str, object]) -> None:
    """Refuse options that are for the other mode."""
    if values["mode"] == "auto" and values["pace"] != 1.0:
        parser.error("--speed with a factor needs --mode guided")
    if values["mode"] == "guided" and values["limits"] == "recorded":
        parser.error("--limits recorded is for missions and cannot be used with --mode guided")
    if values["mode"] == "guided" and values["route"] == "fit":
        parser.error("--mode guided follows the recording without waypoints; leave out --route fit")
