"""The fit beside the classic reducers: distances in space and time, planned and predicted.

    python benchmarks/fit.py [LOG] [--flight N] [--max-points N]

All follow the flown part of the log (default: the sample flight). "Planned" is the distance in order
from the path on paper, "predicted" that from the path which the model of ArduCopter flies, at the
vehicle's own speed for the reducers. Needs the package ``simplification``; GPSBabel joins if installed.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
from reducers import reducers

from flight_replay.geometry.distances import (
    ErrorStatistics,
    error_statistics,
    path_errors_m,
    position_errors_m,
)
from flight_replay.logs.flights import select
from flight_replay.logs.tlog import read_log
from flight_replay.planning.altitude import RECORDED
from flight_replay.planning.fit import fit
from flight_replay.planning.fit.line_simplification import straight_draft
from flight_replay.planning.fit.reference import LocalTrack, local_track
from flight_replay.planning.fit.simulated_draft import simulate_draft
from flight_replay.planning.flown_part import flown_part
from flight_replay.simulator.dynamics.limits import Limits

SAMPLE = Path(__file__).resolve().parents[1] / "data" / "flight.tlog"
ALTITUDE_M = 30.0
STEP_S = 0.05


def numbers(distances: ErrorStatistics | None) -> str:
    return "-" if distances is None else f"{distances.mean:.2f} / {distances.p95:.2f} / {distances.max:.2f}"


def row(name: str, points: int, *cells: str) -> None:
    print(f"| {name} | {points} | {' | '.join(cells)} |", flush=True)


def reduced(name: str, recording: LocalTrack, kept: np.ndarray, cpu_s: float) -> None:
    """One reducer: its straight route on paper and in the model's air."""
    draft = straight_draft(recording, kept)
    fixes = recording.north_east_m
    covered = fixes[: kept[-1] + 1]
    air = simulate_draft(draft, Limits(), STEP_S)
    there = air.place_m[:, :2]
    late = position_errors_m(recording.time_s[: kept[-1] + 1], covered, air.time_s, there)
    row(
        name + ("" if len(covered) == len(fixes) else f", covers {100 * len(covered) // len(fixes)} %"),
        len(kept),
        numbers(error_statistics(path_errors_m(covered, draft.path(0.001).north_east_m))),
        numbers(error_statistics(path_errors_m(covered, there))),
        f"{late.mean():.1f}",
        f"{air.passed_s[-1]:.0f}",
        f"{cpu_s:.1f}",
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("log", nargs="?", type=Path, default=SAMPLE)
    parser.add_argument("--flight", type=int)
    parser.add_argument("--max-points", type=int, default=100)
    options = parser.parse_args()
    part, notes = flown_part(select(read_log(options.log).track, options.flight))
    recording = local_track(part, ALTITUDE_M)
    print(
        f"{options.log.name}: {len(part)} fixes, {part.length_m:.0f} m, {recording.time_s[-1]:.0f} s", *notes
    )
    print(
        "\n| route | points | planned, m | predicted in space, m | in time, m | lasts, s | computed in, s |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for name, reducer in reducers().items():
        begin = time.process_time()
        kept = reducer(recording.north_east_m, options.max_points)
        reduced(name, recording, kept, time.process_time() - begin)
    for name, speed in (("fit", None), ("fit, recorded speed", RECORDED)):
        begin = time.process_time()
        found = fit(part, max_points=options.max_points, altitude_m=ALTITUDE_M, speed_m_s=speed)
        row(
            name,
            len(found.mission.waypoints),
            numbers(found.planned_error),
            numbers(found.path_error),
            f"{found.position_error.mean:.1f}",
            f"{found.predicted_duration_s:.0f}",
            f"{time.process_time() - begin:.1f}",
        )


if __name__ == "__main__":
    main()
