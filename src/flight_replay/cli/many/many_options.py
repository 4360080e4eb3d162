"""The options of ``flight-replay-many``: those of ``flight-replay`` for every flight, and its own."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flight_replay.cli import option_groups, option_types
from flight_replay.cli.many.job import BY_THE_CLOCK, FLY_WITH, Job
from flight_replay.cli.many.log_content import file_sha256
from flight_replay.cli.options import parse_options
from flight_replay.output.many.fleet_comparison import Tolerance

_EXAMPLES = """\
examples:
  flight-replay-many logs/
      say what is in these logs, and plan every flight
  flight-replay-many logs/ --fly model --route fit --duration all --out results.parquet
      fly every flight in the flight model, whole; started again, it goes on where it stopped
  flight-replay-many logs/ --fly sitl --sitl ./arducopter --speedup 10 --out new.parquet
      fly every flight on an ArduPilot SITL binary
  flight-replay-many --compare old.parquet new.parquet
      say which flights became better or worse; exit status 1 if one became worse
  find /archive -name '*.tlog' | flight-replay-many - --scheduler tcp://head:8786 --out all.parquet
      plan on a Dask cluster
"""
_TOLERANCE_M, _TOLERANCE_PERCENT = 0.2, 10.0
_WITH_COMPARE = ("compare", "tolerance_m", "tolerance_percent", "json", "quiet", "verbose")
"""What a comparison knows of the options, by their destinations."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ManyOptions:
    """The parsed options; ``argv`` is what they were parsed from."""

    argv: tuple[str, ...]
    paths: tuple[str, ...]
    compare: tuple[Path, Path] | None
    tolerance: Tolerance
    job: Job
    workers: int | None
    scheduler: str | None
    out: Path | None
    redo_failed: bool
    report: Path | None
    force: bool
    json: bool
    quiet: bool
    verbose: bool


def parse_many_options(argv: Sequence[str]) -> ManyOptions:
    """Parse the command line.

    Raises:
        SystemExit: 2 for wrong usage, 0 after ``--help`` or ``--version``.
        FlightReplayError: The SITL binary cannot be read.
    """
    parser = build_many_parser()
    values = vars(parser.parse_args(argv))
    _check(parser, values)
    arguments = _replay_arguments(argv)
    job = Job(
        arguments=arguments,
        fly=values["fly"],
        sitl=None if values["sitl"] is None else str(values["sitl"]),
        sitl_sha256=None if values["sitl"] is None else file_sha256(values["sitl"]),
        speedup=values["speedup"],
        time_limit_s=values["time_limit_s"],
    )
    parse_options(job.replay_arguments("log", None, None))  # says what does not go together
    return ManyOptions(
        argv=tuple(argv),
        paths=tuple(values["paths"]),
        compare=None if values["compare"] is None else tuple(values["compare"]),
        tolerance=_tolerance(values),
        job=job,
        **{
            name: values[name]
            for name in (
                "workers", "scheduler", "out", "redo_failed", "report", "force", "json", "quiet", "verbose",
            )
        },
    )  # fmt: skip


def _tolerance(values: dict[str, Any]) -> Tolerance:
    metres, percent = values["tolerance_m"], values["tolerance_percent"]
    return Tolerance(
        _TOLERANCE_M if metres is None else metres,
        (_TOLERANCE_PERCENT if percent is None else percent) / 100.0,
    )


def build_many_parser() -> argparse.ArgumentParser:
    """The parser of ``flight-replay-many``."""
    parser = option_groups.new_parser(
        "flight-replay-many",
        "Read, plan and fly again the flights of many logs, on all cores of this machine or on\n"
        "a Dask cluster; every flight becomes a row of one table.",
        _EXAMPLES,
    )
    _add_logs_group(parser)
    _add_replay_groups(parser)
    _add_run_group(parser)
    _add_results_group(parser)
    _add_compare_group(parser)
    return parser


def _add_logs_group(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("logs")
    group.add_argument(
        "paths",
        metavar="PATH",
        nargs="*",
        help="logs, folders that are searched for logs, or - for a list of paths on standard input",
    )
    option_groups.add_part_of_log(
        group,
        vehicle="read only this vehicle of each log (default: all of them)",
        flight="read only the Nth flight of each vehicle, from arming to disarming (default: all of them)",
    )


def _add_replay_groups(parser: argparse.ArgumentParser) -> None:
    """How each flight is planned and flown: as with ``flight-replay``."""
    option_groups.add_route_group(parser)
    group = parser.add_argument_group("flight")
    group.add_argument(
        "--fly",
        choices=FLY_WITH,
        default="none",
        help="none: plan only; model: fly in the flight model; builtin: on the built-in copter, through "
        "DroneKit; sitl: on ArduPilot SITL, downloaded if there is none (default: %(default)s)",
    )
    group.add_argument("--sitl", metavar="PATH", type=Path, help="ArduPilot SITL binary, for --fly sitl")
    option_groups.add_flight(group)
    option_groups.add_max_error(group)
    option_groups.add_speedup(group, "simulation speed as a multiple of real time (default: 1)")


def _add_run_group(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("run")
    group.add_argument(
        "--workers",
        metavar="N",
        type=option_types.count,
        help="flights at once (default: one for each core, with --scheduler one for each of its threads)",
    )
    group.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="Dask scheduler to run on, such as tcp://head:8786 (default: processes on this machine)",
    )
    group.add_argument(
        "--time-limit",
        dest="time_limit_s",
        metavar="S",
        type=option_types.positive,
        help="time for a flight in seconds of the wall clock; a flight that takes longer is given up "
        "(default: 600, and three times what a simulator takes to fly it)",
    )


def _add_results_group(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("results")
    group.add_argument(
        "--out",
        metavar="FILE",
        type=Path,
        help="table of all flights, .parquet or .csv; if it exists, only what is new is done and added",
    )
    group.add_argument(
        "--redo-failed", action="store_true", help="do flights of the table again that did not go as asked"
    )
    group.add_argument(
        "--report", metavar="FILE.html", type=Path, help="save a report of all flights as HTML"
    )
    group.add_argument("--force", action="store_true", help="replace a report that exists")
    group.add_argument(
        "--json",
        action="store_true",
        help="write JSON Lines to standard output: every row as it comes, and the summary",
    )
    group.add_argument("-v", dest="verbose", action="store_true", help="show tracebacks")
    group.add_argument("-q", dest="quiet", action="store_true", help="show only errors")
    group.add_argument(
        "--version",
        action=option_groups.VersionAction,
        nargs=0,
        dest=argparse.SUPPRESS,
        default=argparse.SUPPRESS,
        help="show the version and exit",
    )


def _add_compare_group(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("compare")
    group.add_argument(
        "--compare",
        metavar=("OLD", "NEW"),
        nargs=2,
        type=Path,
        help="say which flights of two tables became better or worse, and exit; nothing is flown",
    )
    group.add_argument(
        "--tolerance",
        dest="tolerance_m",
        metavar="M",
        type=option_types.not_negative,
        help="differences of an error up to this are no change, metres, or degrees times ten "
        f"(default: {_TOLERANCE_M:g})",
    )
    group.add_argument(
        "--tolerance-percent",
        metavar="P",
        type=option_types.not_negative,
        help=f"nor are those up to this share of the old error (default: {_TOLERANCE_PERCENT:g})",
    )


def _check(parser: argparse.ArgumentParser, values: dict[str, Any]) -> None:
    """Refuse options that exclude each other."""
    if bool(values["paths"]) == bool(values["compare"]):
        parser.error("name logs, folders or - to read, or two tables with --compare")
    _check_compare(parser, values)
    if values["sitl"] is not None and values["fly"] != "sitl":
        parser.error("--sitl is for --fly sitl")
    if values["speedup"] is not None and values["fly"] not in BY_THE_CLOCK:
        parser.error("--speedup is for --fly builtin and --fly sitl")
    if values["verbose"] and values["quiet"]:
        parser.error("-v and -q cannot be used together")
    if values["redo_failed"] and values["out"] is None:
        parser.error("--redo-failed is for a table that exists; name it with --out")


def _check_compare(parser: argparse.ArgumentParser, values: dict[str, Any]) -> None:
    """Refuse with ``--compare`` what is for flights, and without it what is for comparisons."""
    given = {
        action.dest: action.option_strings[0]
        for action in parser._actions
        if action.option_strings and values.get(action.dest, action.default) != action.default
    }
    if values["compare"]:
        for name, option in given.items():
            if name not in _WITH_COMPARE:
                parser.error(f"{option} cannot be used with --compare")
        return
    for name in ("tolerance_m", "tolerance_percent"):
        if name in given:
            parser.error(f"{given[name]} is for --compare")


def _replay_arguments(argv: Sequence[str]) -> tuple[str, ...]:
    """The options that ``flight-replay`` has too, as they were typed, without those that say the default."""
    parser, texts = build_many_parser(), build_many_parser()
    for action in texts._actions:
        action.type = None
    typed, text = vars(parser.parse_args(argv)), vars(texts.parse_args(argv))
    arguments: list[str] = []
    for action in _actions_of_replays():
        if typed[action.dest] != parser.get_default(action.dest):
            arguments.append(action.option_strings[0])
            if action.nargs != 0:
                arguments.append(text[action.dest])
    return tuple(arguments)


def _actions_of_replays() -> list[argparse.Action]:
    """The options that are handed on to each replay: those about the log, the route and the flight."""
    parser = argparse.ArgumentParser(add_help=False)
    option_groups.add_part_of_log(parser.add_argument_group(), vehicle="", flight="")
    option_groups.add_route_group(parser)
    group = parser.add_argument_group()
    option_groups.add_flight(group)
    option_groups.add_max_error(group)
    return parser._actions
