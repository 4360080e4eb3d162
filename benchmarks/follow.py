"""The recording followed in GUIDED beside the fitted mission and the 3 m rule: errors of all three.

    python benchmarks/follow.py [LOG] [--flight N] [--altitude A] [--fly | --sitl PATH] [--speedup X]

All replay the same part of a log (default: the sample flight). Errors are mean / p95 / max: the position
error at equal times, the path error both ways, the height error and the heading error. "Predicted" is
what the model of ArduCopter flies at its defaults. With ``--fly`` each is flown through DroneKit too, on
the built-in copter, and with ``--sitl`` on a real ArduCopter, whose limits the prediction then has. A
machine that does not keep up with ``--speedup`` spoils what is flown, above all in GUIDED.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from flight_replay.cli.flight_result import FlightResult
from flight_replay.cli.flight_step import fly
from flight_replay.cli.options import Options, parse_options
from flight_replay.cli.plan_step import Planner, read_recording
from flight_replay.events import ignore
from flight_replay.geometry.error_statistics import ErrorStatistics
from flight_replay.geometry.flight_errors import FlightErrors
from flight_replay.logs.sample import sample_log
from flight_replay.output.console.console import open_console
from flight_replay.planning.route import Route
from flight_replay.planning.vehicle_limits import VehicleLimits

WAYS = {
    "3 m rule": ["--route", "spacing"],
    "fitted mission, recorded speed": ["--route", "fit", "--speed", "recorded"],
    "followed in GUIDED": ["--mode", "guided"],
}
COLUMNS = ["replayed by", "position error, m", "recorded to flown, m", "flown to recorded, m"]
COLUMNS += ["height error, m", "heading error, deg", "duration, s"]
WHOLE = {"final waypoint", "mission complete", "recording complete"}


def numbers(error: ErrorStatistics | None, digits: int = 2) -> str:
    if error is None:
        return "-"
    return f"{error.mean:.{digits}f} / {error.p95:.{digits}f} / {error.max:.{digits}f}"


def row(name: str, errors: FlightErrors | None, duration_s: float) -> None:
    if errors is None:
        print(f"| {name} | too long for the model |", flush=True)
        return
    cells = [
        name,
        numbers(errors.position_m.statistics),
        numbers(errors.path_m.recorded_to_path.statistics),
        numbers(errors.path_m.path_to_recorded.statistics),
        numbers(errors.height_m.statistics),
        numbers(errors.heading_deg.statistics, 1),
        f"{duration_s:.0f}",
    ]
    print(f"| {' | '.join(cells)} |", flush=True)


def covering(fixes: int, of_fixes: int) -> str:
    return "" if fixes >= of_fixes else f", covers {100 * fixes // of_fixes} %"


def replayed(options: Options, *, flown: bool) -> tuple[Route, FlightResult | None]:
    """The route of one way to replay the log, and its flight."""
    _, _, track = read_recording(options, ignore)
    planner = Planner(options, track, ignore)
    if not flown:
        return planner.route(VehicleLimits()), None
    with open_console(sys.stderr, quiet=True, verbose=False) as console:
        return fly(options, planner.home, planner.route, console, ignore)


def show(name: str, route: Route, flight: FlightResult | None) -> None:
    kinds = ", predicted" if flight else ""
    part = covering(len(route.wanted), len(route.recording))
    row(f"{name}{part}{kinds}", route.predicted, route.predicted_duration_s)
    if flight:
        coverage = flight.outcome.coverage
        part = covering(coverage.fixes, coverage.of_fixes)
        row(f"{name}{part}, flown", flight.outcome.errors, flight.record.auto_s)
        if flight.record.ended not in WHOLE:
            print(f"{name}: ended by {flight.record.ended}, {flight.record.problem}", file=sys.stderr)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("log", nargs="?", type=Path, default=sample_log())
    parser.add_argument("--flight", type=int)
    parser.add_argument("--altitude", default="30", help="as flight-replay takes it (default: 30)")
    parser.add_argument("--fly", action="store_true", help="fly it on the built-in copter")
    parser.add_argument("--sitl", type=Path, help="fly it on this ArduPilot SITL binary")
    parser.add_argument("--speedup", type=float, default=5.0, help="of the simulator (default: 5)")
    asked = parser.parse_args()
    arguments = ["--tlog", str(asked.log), "--altitude", asked.altitude, "--duration", "all"]
    arguments += ["--flight", str(asked.flight)] if asked.flight else []
    arguments += ["--sitl", str(asked.sitl)] if asked.sitl else ["--sim", "builtin"]
    arguments += ["--speedup", f"{asked.speedup:g}"]
    begin_s = time.monotonic()
    print(f"| {' | '.join(COLUMNS)} |\n|{' --- |' * len(COLUMNS)}")
    for name, way in WAYS.items():
        options = parse_options([*arguments, *way])
        route, flight = replayed(options, flown=asked.fly or asked.sitl is not None)
        show(name, route, flight)
    fixes, length_m = len(route.recording), route.recording.length_m
    print(f"\n{asked.log.name}: {fixes} fixes, {length_m:.0f} m; {time.monotonic() - begin_s:.0f} s")


if __name__ == "__main__":
    main()
