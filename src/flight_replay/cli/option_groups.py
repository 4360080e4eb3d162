"""The options in groups, as ``--help`` shows them; each group has a command line as an example."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from flight_replay.cli import option_types
from flight_replay.output.console.terminal import write_line, write_verbatim
from flight_replay.planning.spacing import MAX_POINTS, SPACING_M
from flight_replay.writing.terminal_text import Parser


def new_parser(prog: str, description: str, examples: str) -> Parser:
    """A parser with ``--help`` alone, which ends with some examples."""
    parser = Parser(
        prog=prog,
        description=description,
        epilog=examples,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
        add_help=False,
    )
    # For an option outside a group argparse formats a help text, which takes longer than parsing.
    group = parser.add_argument_group("options")
    group.add_argument("-h", "--help", action="help", help="show this help message and exit")
    return parser


def add_groups(parser: argparse.ArgumentParser) -> None:
    """Add every option to a parser."""
    for add_group in (_log_group, add_route_group, _flight_group, _vehicle_group, _output_group):
        add_group(parser)


def _log_group(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("log", "example: flight-replay flight.bin --flight 2")
    group.add_argument(
        "log",
        metavar="LOG",
        nargs="?",
        help="log to replay: telemetry log (.tlog), DataFlash (.bin, .log), ULog, GPX, KML, KMZ, CSV or "
        "GeoJSON, found by what it holds, plain or compressed with gzip; - reads standard input "
        "(default: flight.tlog in this folder, else the sample flight of the package)",
    )
    _add_looking(group)
    add_part_of_log(
        group,
        vehicle="vehicle to replay, if the log has several (default: the one with the most fixes)",
        flight="replay only the Nth flight of the log, from arming to disarming (default: the whole log)",
    )


def add_part_of_log(group: argparse._ArgumentGroup, *, vehicle: str, flight: str) -> None:
    """Which vehicle, flight and seconds of a log to replay.

    Args:
        group: gets the options.
        vehicle: the help of ``--vehicle``, with its default.
        flight: that of ``--flight``.
    """
    group.add_argument(
        "--vehicle",
        metavar="SYSID[:COMPID]",
        type=option_types.vehicle_id,
        help=vehicle,
    )
    group.add_argument(
        "--flight",
        metavar="N",
        type=option_types.count,
        help=flight,
    )
    group.add_argument(
        "--from",
        dest="from_s",
        metavar="S",
        type=option_types.not_negative,
        help="leave out the first S seconds",
    )
    group.add_argument(
        "--to",
        dest="to_s",
        metavar="S",
        type=option_types.positive,
        help="leave out everything after the first S seconds",
    )


def _add_looking(group: argparse._ArgumentGroup) -> None:
    """Other ways to name the log, and what is only looked at."""
    group.add_argument("--tlog", metavar="FILE", help="the same as LOG")
    group.add_argument("--info", action="store_true", help="show what the log holds, and exit")
    group.add_argument(
        "--compare",
        nargs=2,
        metavar=("A", "B"),
        help="measure log B, a replay by its AUTO or GUIDED part, against log A, or its flight of --flight, "
        "and exit",
    )


def add_route_group(parser: argparse.ArgumentParser) -> None:
    """How to plan."""
    group = parser.add_argument_group("route", "example: flight-replay --route fit --altitude recorded")
    group.add_argument(
        "--mode",
        choices=("auto", "guided"),
        default="auto",
        help="auto: fly a mission; guided: follow the recording in step with it, at its place, time and "
        "heading, and with --altitude recorded its height (default: %(default)s)",
    )
    group.add_argument(
        "--route",
        choices=("spacing", "fit"),
        default="spacing",
        help="spacing: a waypoint every few metres, up to the maximum number; fit: straight and spline "
        "waypoints that follow the whole flight closely (default: %(default)s)",
    )
    group.add_argument(
        "--spacing",
        dest="spacing_m",
        metavar="M",
        type=option_types.not_negative,
        help="minimum distance between waypoints in metres, with recorded heights in space, "
        f"for --route spacing (default: {SPACING_M:g})",
    )
    group.add_argument(
        "--max-points",
        metavar="N",
        type=option_types.points,
        help=f"maximum number of waypoints (default: {MAX_POINTS})",
    )
    _add_motion(group)


def _add_motion(group: argparse._ArgumentGroup) -> None:
    """How high, how fast and pointing where to fly the waypoints."""
    group.add_argument(
        "--altitude",
        dest="altitude_m",
        metavar="{M,recorded,recorded+M}",
        type=option_types.altitude,
        default=(30.0, 0.0),
        help="altitude to fly at: metres above home, as recorded, or so many metres higher (default: 30)",
    )
    group.add_argument(
        "--floor",
        dest="floor_m",
        metavar="M",
        type=option_types.height,
        help="lowest altitude to fly at in metres above home, for recorded altitudes (default: 5)",
    )
    group.add_argument(
        "--speed",
        dest="speed_m_s",
        metavar="{vehicle,recorded,M_PER_S,FACTORx}",
        type=option_types.speed,
        default=(None, 1.0),
        help="vehicle: its own speed setting; recorded: the recorded speed; or metres per second "
        "(default: vehicle); with --mode guided, that of the way to the first fix, or 0.5x for half "
        "the recorded speed",
    )
    group.add_argument(
        "--heading",
        choices=("vehicle", "recorded"),
        help="vehicle: its own way, mostly along the path; recorded: as the recorded vehicle pointed "
        "(default: vehicle, with --mode guided recorded)",
    )


def _flight_group(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("flight", "example: flight-replay --duration all --land")
    add_flight(group)
    group.add_argument(
        "--passes",
        metavar="N",
        type=option_types.count,
        help="with --mode guided, times that a simulated vehicle follows the recording: each pass learns "
        "from the errors of those before, and the last is measured (default: 1)",
    )
    _add_safety(group)


def add_flight(group: argparse._ArgumentGroup) -> None:
    """How long, how fast and how high to fly, and how to end."""
    group.add_argument(
        "--duration",
        dest="duration_s",
        metavar="{S,all}",
        type=option_types.duration,
        default=60.0,
        help="time in AUTO, or of the recording with --mode guided: seconds, or all (default: 60)",
    )
    group.add_argument(
        "--limits",
        choices=("vehicle", "recorded"),
        default="vehicle",
        help="vehicle: plan with the vehicle's own limits; recorded: for this flight, raise the speed and "
        "acceleration limits of a simulated vehicle to those of the recording (default: %(default)s)",
    )
    group.add_argument(
        "--takeoff-altitude",
        dest="takeoff_altitude_m",
        metavar="M",
        type=option_types.height,
        help="take-off altitude in metres above home (default: 30)",
    )
    group.add_argument(
        "--land",
        action="store_true",
        help="wait until the vehicle has landed and disarmed (default: exit once RTL is confirmed)",
    )


def _add_safety(group: argparse._ArgumentGroup) -> None:
    """What is refused, or asked for, before anything flies."""
    group.add_argument(
        "--max-distance",
        dest="max_distance_m",
        metavar="M",
        type=option_types.positive,
        help="maximum distance of the first waypoint from the vehicle in metres (default: 1000)",
    )
    add_max_error(group)
    group.add_argument(
        "--yes", action="store_true", help="arm a real vehicle without asking for confirmation"
    )


def add_max_error(group: argparse._ArgumentGroup) -> None:
    """How far a vehicle may be from the recording that it follows."""
    group.add_argument(
        "--max-error",
        dest="max_error_m",
        metavar="M",
        type=option_types.positive,
        help="with --mode guided, the recording waits for a vehicle farther away from it than this, and "
        "three times as far ends the flight (default: 3)",
    )


def _vehicle_group(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("vehicle", "example: flight-replay --connect /dev/ttyUSB0 --baud 57600")
    group.add_argument(
        "--connect",
        metavar="STRING",
        help="vehicle to fly: udpin:, udpout: or tcp:HOST:PORT, or a serial port "
        "(default: start a simulator)",
    )
    group.add_argument(
        "--baud",
        metavar="N",
        type=option_types.baud,
        help="baud rate of a serial port (default: 57600)",
    )
    group.add_argument(
        "--wait",
        action="store_true",
        help="wait for the vehicle as long as it takes (default: 30 s for its heartbeat)",
    )
    group.add_argument(
        "--signing-key",
        metavar="FILE",
        type=Path,
        help="sign messages to the vehicle, and ignore unsigned ones, with the key in this file: "
        "64 hexadecimal digits or a passphrase",
    )
    group.add_argument(
        "--sim",
        choices=("auto", "sitl", "builtin"),
        help="simulator to start: ArduPilot SITL, downloaded if there is none, or the built-in copter; "
        "auto: SITL if there is one on this machine, else the built-in copter (default: auto)",
    )
    group.add_argument("--sitl", metavar="PATH", type=Path, help="ArduPilot SITL binary to start")
    add_speedup(
        group, "simulation speed as a multiple of real time (default: 1; with --connect, left as it is)"
    )


def add_speedup(group: argparse._ArgumentGroup, text: str) -> None:
    """How fast a simulator runs; ``text`` is its help, with the default."""
    group.add_argument("--speedup", metavar="X", type=option_types.speedup, help=text)


def _output_group(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group(
        "output", "example: flight-replay --plot replay.png --json > replay.json"
    )
    group.add_argument(
        "--dry-run",
        action="store_true",
        help="plan the route, but do not fly; with --connect, for that vehicle",
    )
    _add_results(group)
    _add_display(group)
    _add_information(group)


def _add_results(group: argparse._ArgumentGroup) -> None:
    """The results of a replay."""
    group.add_argument("--json", action="store_true", help="write one JSON object to standard output")
    group.add_argument(
        "--save",
        metavar="FILE",
        type=Path,
        action="append",
        help="save the mission as .waypoints (MAVProxy, Mission Planner) or .plan (QGroundControl), and the "
        "recorded track with it, or with --mode guided without one, as .kml (Google Earth), .gpx, .geojson "
        "or .csv (repeatable)",
    )
    group.add_argument(
        "--bare",
        action="store_true",
        help="save .waypoints and .plan without take-off and return to launch, which they begin and end with",
    )
    group.add_argument("--record", metavar="FILE.tlog", type=Path, help="record all MAVLink traffic")
    group.add_argument(
        "--plot", metavar="FILE", type=Path, help="save a plot of the replay as .png, .svg or .pdf"
    )
    group.add_argument("--report", metavar="FILE.html", type=Path, help="save a report of the replay as HTML")
    group.add_argument("--force", action="store_true", help="replace output files that exist")


def _add_display(group: argparse._ArgumentGroup) -> None:
    """Ground stations, the live map and the console."""
    group.add_argument(
        "--gcs",
        metavar="STRING",
        action="append",
        help="share the vehicle with a ground station: send to udpout:HOST:PORT, connect to tcp:HOST:PORT, "
        "or listen at udpin:HOST:PORT or tcpin:HOST:PORT (repeatable)",
    )
    group.add_argument(
        "--gcs-open",
        action="store_true",
        help="let --gcs tcpin: and udpin: listen for other machines too: they can command the vehicle",
    )
    group.add_argument(
        "--map", action="store_true", help="show a live map in the browser, with --dry-run the plan"
    )
    group.add_argument(
        "--map-tiles",
        action="store_true",
        help="put OpenStreetMap below the live map: its server learns where the flight is",
    )
    group.add_argument("-v", dest="verbose", action="store_true", help="show more output, and tracebacks")
    group.add_argument("-q", dest="quiet", action="store_true", help="show only warnings and errors")


def _add_information(group: argparse._ArgumentGroup) -> None:
    """Options that print something and exit."""
    group.add_argument(
        "--print-completion",
        metavar="{bash,zsh,tcsh}",
        choices=("bash", "zsh", "tcsh"),
        action=_Completion,
        dest=argparse.SUPPRESS,
        default=argparse.SUPPRESS,
        help="print a shell completion script and exit",
    )
    group.add_argument(
        "--version",
        action=VersionAction,
        nargs=0,
        dest=argparse.SUPPRESS,
        default=argparse.SUPPRESS,
        help="show the version and exit",
    )


class VersionAction(argparse.Action):
    """Prints the version, which is read from the package's metadata only then."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        """Print it, and exit."""
        from importlib.metadata import version

        write_line(sys.stdout, f"{parser.prog} {version('flight-replay')}")
        parser.exit()


class _Completion(argparse.Action):
    """Prints the script that completes this command line in a shell."""

    def __call__(
        self, parser: argparse.ArgumentParser, _namespace: object, shell: object, *_: object
    ) -> None:
        import shtab

        write_verbatim(sys.stdout, shtab.complete(parser, str(shell)))
        parser.exit()
