"""The command line's options: one table for parsing and help, and plain data for everybody else."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from flight_replay import option_types
from flight_replay.decimate import MAX_POINTS, SPACING_M
from flight_replay.option_types import Recorded

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
        description="Fly a recorded drone flight again: from a MAVLink telemetry log (.tlog) to a waypoint "
        "mission, to a simulator or a real vehicle, and home.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    for add_group in (_log_group, _route_group, _flight_group, _vehicle_group, _output_group):
        add_group(parser)
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


def _log_group(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("log", "example: flight-replay --tlog flight.tlog --flight 2")
    group.add_argument(
        "--tlog",
        metavar="FILE",
        help="the recorded flight; .gz is read as it is, - reads standard input "
        "(default: flight.tlog in this folder, else the sample flight that comes with the package)",
    )
    group.add_argument(
        "--vehicle",
        metavar="SYSID[:COMPID]",
        type=option_types.vehicle_id,
        help="which vehicle of the log (default: the one with most fixes)",
    )
    group.add_argument(
        "--flight",
        metavar="N",
        type=option_types.count,
        help="only the Nth flight of the log, from arming to disarming (default: the whole log)",
    )
    group.add_argument(
        "--from",
        dest="from_s",
        metavar="S",
        type=option_types.not_negative,
        help="leave out what was before this second",
    )
    group.add_argument(
        "--to",
        dest="to_s",
        metavar="S",
        type=option_types.positive,
        help="leave out what was after this second",
    )


def _route_group(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("route", "example: flight-replay --route fit --altitude recorded")
    group.add_argument(
        "--route",
        choices=("spacing", "fit"),
        default="spacing",
        help="spacing: a waypoint every few metres until there are enough; fit: straight and spline "
        "waypoints that follow the whole flight best (default: %(default)s)",
    )
    group.add_argument(
        "--spacing",
        dest="spacing_m",
        metavar="M",
        type=option_types.not_negative,
        default=SPACING_M,
        help="spacing: metres between waypoints (default: 3)",
    )
    group.add_argument(
        "--max-points",
        metavar="N",
        type=option_types.count,
        default=MAX_POINTS,
        help="the most waypoints (default: %(default)s)",
    )
    group.add_argument(
        "--altitude",
        dest="altitude_m",
        metavar="{M,recorded}",
        type=option_types.altitude,
        default=30.0,
        help="metres above home to fly at, or as recorded (default: 30)",
    )
    group.add_argument(
        "--speed",
        dest="speed_m_s",
        metavar="{vehicle,recorded,M_PER_S}",
        type=option_types.speed,
        help="the vehicle's own speed setting, as recorded, or metres per second (default: vehicle)",
    )


def _flight_group(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("flight", "example: flight-replay --duration all --land")
    group.add_argument(
        "--duration",
        dest="duration_s",
        metavar="{S,all}",
        type=option_types.duration,
        default=60.0,
        help="seconds of the vehicle's clock to fly the mission for, or all of it (default: 60)",
    )
    group.add_argument(
        "--limits",
        choices=("vehicle", "recorded"),
        default="vehicle",
        help="recorded: raise the speed and acceleration limits of a simulated vehicle to what the "
        "recording shows, for this flight (default: %(default)s)",
    )
    group.add_argument(
        "--takeoff-altitude",
        dest="takeoff_altitude_m",
        metavar="M",
        type=option_types.positive,
        default=30.0,
        help="metres above home to climb to first (default: 30)",
    )
    group.add_argument(
        "--land",
        action="store_true",
        help="stay until it has landed and disarmed (default: leave once RTL is confirmed)",
    )
    group.add_argument(
        "--max-distance",
        dest="max_distance_m",
        metavar="M",
        type=option_types.positive,
        default=1000.0,
        help="refuse a route that begins farther than this from home (default: 1000)",
    )
    group.add_argument("--yes", action="store_true", help="arm a real vehicle without asking")


def _vehicle_group(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("vehicle", "example: flight-replay --connect /dev/ttyUSB0 --baud 57600")
    group.add_argument(
        "--connect",
        metavar="STRING",
        help="127.0.0.1:14550, udp:, udpout:, tcp:HOST:PORT or a serial port (default: start a simulator)",
    )
    group.add_argument(
        "--baud",
        metavar="N",
        type=option_types.count,
        default=57600,
        help="speed of a serial port (default: %(default)s)",
    )
    group.add_argument(
        "--sim",
        choices=("auto", "sitl", "builtin"),
        help="ArduPilot SITL, the built-in copter, or SITL where one is at hand (default: auto)",
    )
    group.add_argument("--sitl", metavar="PATH", type=Path, help="the ArduPilot SITL binary to start")
    group.add_argument(
        "--speedup",
        metavar="X",
        type=option_types.positive,
        help="how many times faster than life a simulator runs (default: 1; with --connect, as it is)",
    )


def _output_group(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group(
        "output", "example: flight-replay --plot replay.png --json > replay.json"
    )
    group.add_argument("--dry-run", action="store_true", help="plan, and fly nothing")
    group.add_argument("--json", action="store_true", help="one JSON object on standard output")
    group.add_argument(
        "--save",
        metavar="FILE",
        type=Path,
        action="append",
        help="keep the mission: .waypoints, .plan, .kml, .gpx, .geojson or .csv (repeatable)",
    )
    group.add_argument(
        "--record", metavar="FILE.tlog", type=Path, help="keep everything the vehicle and we said"
    )
    group.add_argument(
        "--plot", metavar="FILE", type=Path, help="a picture of the replay: .png, .svg or .pdf"
    )
    group.add_argument("--report", metavar="FILE.html", type=Path, help="a report of the replay in one file")
    group.add_argument(
        "--gcs",
        metavar="STRING",
        action="append",
        help="let a ground station watch, udp:HOST:PORT or tcp:HOST:PORT (repeatable)",
    )
    group.add_argument("--map", action="store_true", help="a live map in the browser")
    group.add_argument("-v", dest="verbose", action="store_true", help="say more, and show tracebacks")
    group.add_argument("-q", dest="quiet", action="store_true", help="say only what went wrong")
    group.add_argument(
        "--version",
        action=_Version,
        nargs=0,
        dest=argparse.SUPPRESS,
        default=argparse.SUPPRESS,
        help="say the version and stop",
    )


class _Version(argparse.Action):
    """Looks the version up only when asked: that reads files, which a plain start need not."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        sys.stdout.write(f"{parser.prog} {version('flight-replay')}\n")
        parser.exit()
