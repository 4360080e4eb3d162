"""The options of the command line: the parser, and the parsed values as plain data."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from flight_replay.cli.option_combinations import check_combinations, without_effect
from flight_replay.cli.option_groups import add_groups, new_parser
from flight_replay.planning.altitude import FLOOR_M, Recorded
from flight_replay.planning.spacing import MAX_POINTS, SPACING_M

_EXAMPLES = """\
examples:
  flight-replay
      fly ./flight.tlog, or the sample flight, on a simulator
  flight-replay flight.bin --info
      show which flights a log holds
  flight-replay flight.tlog --speedup 10
      fly your own log, ten times faster than real time
  flight-replay --connect udpin:127.0.0.1:14550
      fly it on the vehicle that sends to this UDP port
  flight-replay --route fit --duration all --speed recorded
      fly the whole flight at the recorded speed
  flight-replay --dry-run --save mission.waypoints
      plan only, and save the mission
"""


DEFAULTS = {
    "floor_m": FLOOR_M,
    "spacing_m": SPACING_M,
    "max_points": MAX_POINTS,
    "max_error_m": 3.0,
    "passes": 1,
    "takeoff_altitude_m": 30.0,
    "max_distance_m": 1000.0,
    "baud": 57600,
}
"""The defaults of options that are told where they have no effect: None says that one was not given."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """The parsed options; lengths in metres, times in seconds, speeds in m/s."""

    log: str | None
    info: bool
    compare: tuple[str, ...] | None
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
    passes: int
    duration_s: float | None
    limits: Literal["vehicle", "recorded"]
    takeoff_altitude_m: float
    land: bool
    max_distance_m: float
    yes: bool
    connect: str | None
    baud: int
    wait: bool
    signing_key: Path | None
    sim: Literal["auto", "sitl", "builtin"]
    sitl: Path | None
    speedup: float | None
    dry_run: bool
    json: bool
    save: tuple[Path, ...]
    bare: bool
    record: Path | None
    plot: Path | None
    report: Path | None
    force: bool
    gcs: tuple[str, ...]
    gcs_open: bool
    map: bool
    map_tiles: bool
    verbose: bool
    quiet: bool
    without_effect: tuple[str, ...] = ()


def parse_options(argv: Sequence[str]) -> Options:
    """Parse the command line.

    Raises:
        SystemExit: 2 for wrong usage, 0 after ``--help`` or ``--version``.
    """
    parser = build_parser()
    values = _parsed(parser, argv)
    check_combinations(parser, values)
    values["without_effect"] = without_effect(values, _parsed(parser, []))
    tlog = values.pop("tlog")
    values["log"] = tlog if values["log"] is None else values["log"]
    for name, default in DEFAULTS.items():
        values[name] = default if values[name] is None else values[name]
    values["sim"] = values["sim"] or ("sitl" if values["sitl"] else "auto")
    values["heading"] = values["heading"] or ("recorded" if values["mode"] == "guided" else "vehicle")
    values["compare"] = values["compare"] and tuple(values["compare"])
    values["save"] = tuple(values["save"] or ())
    values["gcs"] = tuple(values["gcs"] or ())
    return Options(**values)


def _parsed(parser: argparse.ArgumentParser, argv: Sequence[str]) -> dict[str, Any]:
    """What is given, by destination."""
    values = vars(parser.parse_args(argv))
    values["altitude_m"], values["raise_m"] = values["altitude_m"]
    values["speed_m_s"], values["pace"] = values["speed_m_s"]
    return values


def build_parser() -> argparse.ArgumentParser:
    """The parser of ``flight-replay``."""
    parser = new_parser(
        "flight-replay",
        "Fly a recorded drone flight again: turn the log of a flight into a mission, fly it\n"
        "on a simulator or a real vehicle, and compare the flight with the recording.",
        _EXAMPLES,
    )
    add_groups(parser)
    return parser
