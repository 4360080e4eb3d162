"""The groups of options in the order of the manual; each shows a command line as an example."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from flight_replay.cli import option_types
from flight_replay.planning.spacing import MAX_POINTS, SPACING_M


def add_groups(parser: argparse.ArgumentParser) -> None:
    """Add every option to a parser."""
    for add_group in (_log_group, _route_group, _flight_group, _vehicle_group, _output_group):
        add_group(parser)


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
    _results(group)
    _watching(group)
    _about_the_program(group)


def _results(group: argparse._ArgumentGroup) -> None:
    """What a replay leaves behind."""
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


def _watching(group: argparse._ArgumentGroup) -> None:
    """How to look on."""
    group.add_argument(
        "--gcs",
        metavar="STRING",
        action="append",
        help="let a ground station watch, udp:HOST:PORT or tcp:HOST:PORT (repeatable)",
    )
    group.add_argument("--map", action="store_true", help="a live map in the browser")
    group.add_argument("-v", dest="verbose", action="store_true", help="say more, and show tracebacks")
    group.add_argument("-q", dest="quiet", action="store_true", help="say only what went wrong")


def _about_the_program(group: argparse._ArgumentGroup) -> None:
    """What is told instead of a replay."""
    group.add_argument(
        "--print-completion",
        metavar="{bash,zsh,tcsh}",
        choices=("bash", "zsh", "tcsh"),
        action=_Completion,
        dest=argparse.SUPPRESS,
        default=argparse.SUPPRESS,
        help="write a script that completes these options in your shell, and stop",
    )
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


class _Completion(argparse.Action):
    """Writes the script that completes this command line in a shell."""

    def __call__(
        self, parser: argparse.ArgumentParser, _namespace: object, shell: object, *_: object
    ) -> None:
        import shtab

        sys.stdout.write(shtab.complete(parser, str(shell)) + "\n")
        parser.exit()
