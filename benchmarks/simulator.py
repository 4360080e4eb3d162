"""The built-in copter against recordings of ArduCopter, and what simulating costs.

    python benchmarks/simulator.py [DIRECTORY] [NAME...]

The directory holds, per mission, NAME.waypoints (QGC WPL 110 with home as item 0), NAME.csv
(GLOBAL_POSITION_INT from arming to landing, with mode) and NAME.json (auto_start_ms, reached,
text), as its README describes. Errors are those of recorded positions in AUTO: the path error,
recorded to ours, and the position error at equal times since the first waypoint was reached.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.flight_errors import errors_at_equal_times
from flight_replay.geometry.matching import match_in_order
from flight_replay.geometry.movement import Movement
from flight_replay.mission.formats import load_mission
from flight_replay.mission.items import Home, Mission, waypoint
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.trajectory import Trajectory, home_frame, simulate, simulate_flight

TRUTH = Path(__file__).resolve().parents[1] / "tests" / "data" / "arducopter"
AUTO, RTL = 3, 6
# An event has the time of the position recorded before it, at 10 Hz: on average half a sample early.
HALF_SAMPLE_S = 0.05
GOAL_TIMES_REAL_TIME = 300


@dataclass(frozen=True, slots=True)
class Recording:
    """A recorded flight: seconds since boot, metres north, east, up of home, and when things happened."""

    mission: Mission
    time_s: Floats
    position_m: Floats
    mode: Floats
    auto_s: float
    reached_s: dict[int, float]
    disarmed_s: float

    @property
    def last_s(self) -> float:
        """When the last item was reached."""
        return max(self.reached_s.values())


def read_recording(directory: Path, name: str) -> Recording:
    mission = load_mission(directory / f"{name}.waypoints")
    columns = np.genfromtxt(directory / f"{name}.csv", delimiter=",", names=True)
    story = json.loads((directory / f"{name}.json").read_text())
    ground = home_frame(mission).to_metres(columns["lat_e7"] * 1e-7, columns["lon_e7"] * 1e-7)
    disarmed = [t for t, text in story["text"] if "Disarming" in text]
    return Recording(
        mission,
        columns["time_boot_ms"] * 1e-3,
        np.column_stack([ground, columns["relative_alt_mm"] * 1e-3]),
        columns["mode"],
        story["auto_start_ms"] * 1e-3 + HALF_SAMPLE_S,
        {seq: t * 1e-3 + HALF_SAMPLE_S for t, seq in story["reached"]},
        disarmed[-1] * 1e-3 if disarmed else float("nan"),
    )


@dataclass(frozen=True, slots=True)
class Result:
    """Errors, m, and durations, s: theirs and ours."""

    path_error: Floats
    position_error: Floats
    auto_s: tuple[float, float]
    takeoff_s: tuple[float, float]
    rtl_s: tuple[float, float]


def compare(truth: Recording, limits: Limits) -> tuple[Result, Trajectory]:
    returning = truth.time_s[truth.mode == RTL]
    flown = simulate_flight(
        truth.mission, limits, after_s=returning[0] - truth.last_s if len(returning) else 0.0
    )
    auto = (truth.time_s >= truth.auto_s) & (truth.time_s <= truth.last_s)
    own_auto = (flown.time_s >= flown.auto_s[0]) & (flown.time_s <= flown.auto_s[1] + 1.0)
    first = min(truth.reached_s)
    unknown = np.full(len(truth.time_s), np.nan)
    theirs = Movement(
        truth.time_s - truth.reached_s[first], truth.position_m[:, :2], truth.position_m[:, 2], unknown
    ).select(auto)
    own_time_s = flown.time_s - flown.reached_s[first]
    ours = Movement(own_time_s, flown.north_east_m, flown.up_m, flown.heading_deg).select(own_auto)
    rtl_begin = returning[0] if len(returning) else float("nan")
    after = rtl_begin - truth.last_s
    return Result(
        match_in_order(theirs.north_east_m, ours.north_east_m).distance_m,
        errors_at_equal_times(theirs, ours)[0].error,
        (truth.last_s - truth.auto_s, flown.auto_s[1] - flown.auto_s[0]),
        (truth.auto_s - truth.time_s[0], flown.auto_s[0]),
        (truth.disarmed_s - rtl_begin, flown.time_s[-1] - flown.auto_s[1] - after),
    ), flown


def percent(pair: tuple[float, float]) -> str:
    return f"{pair[0]:7.1f} {100 * (pair[1] / pair[0] - 1):+5.1f} %"


def show(name: str, result: Result) -> None:
    errors = (result.path_error, result.position_error)
    shown = "   ".join(f"{error.mean():6.3f} {error.max():6.3f}" for error in errors)
    durations = "  ".join(percent(pair) for pair in (result.auto_s, result.takeoff_s, result.rtl_s))
    print(f"{name:20s} {shown}  {durations}")


def show_cost() -> None:
    """A mission of 100 items, 10 m apart on a spiral, in the best of three tries."""
    mission = spiral(100)
    best_s = float("inf")
    for _ in range(3):
        begin_s = time.process_time()
        flown = simulate(mission, Limits())
        best_s = min(best_s, time.process_time() - begin_s)
    duration_s = flown.auto_s[1] - flown.auto_s[0]
    print(
        f"100 items: {duration_s:.0f} s flown in {best_s:.3f} s of CPU time, "
        f"{duration_s / best_s:.0f} times real time (at least {GOAL_TIMES_REAL_TIME})"
    )


def spiral(count: int) -> Mission:
    angle = np.cumsum(10.0 / (20.0 + np.arange(count)))
    places = (20.0 + np.arange(count))[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    frame = home_frame(Mission((), Home(47.0, 8.0, 0.0)))
    lat, lon = frame.to_degrees(places)
    items = tuple(waypoint(a, b, 30.0) for a, b in zip(lat.tolist(), lon.tolist(), strict=True))
    return Mission(items, Home(47.0, 8.0, 0.0))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("directory", nargs="?", type=Path, default=TRUTH)
    parser.add_argument("names", nargs="*")
    options = parser.parse_args()
    directory = options.directory
    names = options.names or sorted(path.stem for path in directory.glob("*.waypoints"))
    print(f"{'':20s} path error, m   position error  AUTO, s          take-off, s      RTL, s")
    print(f"{'':20s}   mean    max     mean    max")
    for name in names:
        result, _ = compare(read_recording(directory, name), Limits())
        show(name, result)
    show_cost()


if __name__ == "__main__":
    main()
