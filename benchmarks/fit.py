"""The fit beside the classic reducers: path error both ways and position error, planned and predicted.

    python benchmarks/fit.py [LOG] [--flight N] [--max-points N] [--jitters N]

All follow the flown part of the log (default: the sample flight). Path errors are mean / p95 / max, from
the recorded fixes to the path and from the path back to the recorded line, where overshoots show.
"Planned" is the path on paper, "predicted" that which the model of ArduCopter flies, at the vehicle's
own speed for the reducers. Needs the package ``simplification``; GPSBabel joins if installed. With
``--jitters`` it tells instead how far apart the fits at the recorded speed are of so many recordings
whose fixes are moved about 1 cm.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from reducers import reducers

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.error_statistics import ErrorStatistics
from flight_replay.geometry.flight_errors import errors_at_equal_times, path_errors
from flight_replay.geometry.movement import Movement
from flight_replay.logs.flights import select
from flight_replay.logs.read_log import read_log
from flight_replay.logs.track import Track
from flight_replay.mission.path import planned_path
from flight_replay.planning.altitude import RECORDED, Recorded
from flight_replay.planning.fit import FitResult, fit
from flight_replay.planning.fit.first_drafts.line_simplification import straight_draft
from flight_replay.planning.fit.reference import LocalTrack, flat_frame, local_track
from flight_replay.planning.fit.simulated_draft import simulate_draft
from flight_replay.planning.flown_part import flown_part
from flight_replay.planning.route import movement_of
from flight_replay.simulator.dynamics.limits import Limits

SAMPLE = Path(__file__).resolve().parents[1] / "data" / "flight.tlog"
ALTITUDE_M = 30.0
STEP_S = 0.05
JITTER_M = 0.01


def numbers(distances: ErrorStatistics | None) -> str:
    return "-" if distances is None else f"{distances.mean:.2f} / {distances.p95:.2f} / {distances.max:.2f}"


def row(name: str, points: int, *cells: str) -> None:
    print(f"| {name} | {points} | {' | '.join(cells)} |", flush=True)


def movement(time_s: Floats, place_m: Floats) -> Movement:
    """A movement over the ground; all else is unknown."""
    unknown = np.full(len(time_s), np.nan)
    return Movement(time_s, place_m[:, :2], unknown, unknown)


def both_ways(fixes: Movement, path_m: Floats) -> tuple[str, str]:
    """Path error of the fixes from a path, and of the path from the recorded line."""
    errors = path_errors(fixes, path_m)
    return numbers(errors.recorded_to_path.statistics), numbers(errors.path_to_recorded.statistics)


def mean_position_error_m(recorded: Movement, flown: Movement) -> float:
    return float(errors_at_equal_times(recorded, flown)[0].error.mean())


def predicted_flight(found: FitResult) -> Movement:
    """The predicted flight of a fit in ground metres."""
    lat_deg, lon_deg = flat_frame(found.flown).to_degrees(found.flight.place_m[:, :2])
    return movement(found.flight.time_s, found.flown.frame.to_metres(lat_deg, lon_deg))


def reduced(name: str, recording: LocalTrack, kept: np.ndarray, cpu_s: float) -> None:
    """One reducer: its straight route on paper and in the model's air."""
    draft = straight_draft(recording, kept)
    covered = movement(recording.time_s[: kept[-1] + 1], recording.north_east_m[: kept[-1] + 1])
    air = simulate_draft(draft, Limits(), STEP_S)
    predicted = movement(air.time_s, air.place_m)
    whole = len(covered) == len(recording)
    row(
        name + ("" if whole else f", covers {100 * len(covered) // len(recording)} %"),
        len(kept),
        *both_ways(covered, draft.path(0.001).north_east_m),
        *both_ways(covered, predicted.north_east_m),
        f"{mean_position_error_m(covered, predicted):.1f}",
        f"{air.passed_s[-1]:.0f}",
        f"{cpu_s:.1f}",
    )


def fitted(name: str, part: Track, max_points: int, speed: Recorded | None) -> None:
    """The fit at the vehicle's own or at the recorded speed."""
    begin = time.process_time()
    found = fit(part, max_points=max_points, altitude_m=ALTITUDE_M, speed_m_s=speed)
    cpu_s = time.process_time() - begin
    frame = found.flown.frame
    fixes, predicted = movement_of(found.flown, frame), predicted_flight(found)
    row(
        name,
        len(found.mission.waypoints),
        *both_ways(fixes, planned_path(found.mission, frame).north_east_m),
        *both_ways(fixes, predicted.north_east_m),
        f"{mean_position_error_m(fixes, predicted):.1f}",
        f"{found.predicted_duration_s:.0f}",
        f"{cpu_s:.1f}",
    )


def jittered(part: Track, seed: int) -> Track:
    """The fixes moved by normally distributed distances."""
    moved_m = part.north_east_m(part.frame)
    moved_m += np.random.default_rng(seed).normal(0.0, JITTER_M, moved_m.shape)
    lat_deg, lon_deg = part.frame.to_degrees(moved_m)
    return replace(part, lat_deg=lat_deg, lon_deg=lon_deg)


def spread(part: Track, max_points: int, count: int) -> None:
    """The objectives and position errors of the fits of so many jittered recordings."""
    found = []
    for seed in range(1, count + 1):
        of_seed = fit(jittered(part, seed), max_points=max_points, altitude_m=ALTITUDE_M, speed_m_s=RECORDED)
        recorded = movement_of(of_seed.flown, of_seed.flown.frame)
        position_error_m = mean_position_error_m(recorded, predicted_flight(of_seed))
        found.append((of_seed.objective_m, position_error_m))
        print("jitter {}: objective {:.2f} m, position error {:.2f} m".format(seed, *found[-1]), flush=True)
    least, most = np.min(found, axis=0), np.max(found, axis=0)
    share = (most - least)[0] / np.mean(found, axis=0)[0]
    print(
        f"objective {least[0]:.2f} to {most[0]:.2f} m, {share:.0%} apart; "
        f"position error {least[1]:.2f} to {most[1]:.2f} m"
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("log", nargs="?", type=Path, default=SAMPLE)
    parser.add_argument("--flight", type=int)
    parser.add_argument("--max-points", type=int, default=100)
    parser.add_argument("--jitters", type=int, default=0)
    options = parser.parse_args()
    part, notes = flown_part(select(read_log(options.log).track, options.flight))
    recording = local_track(part, ALTITUDE_M)
    print(
        f"{options.log.name}: {len(part)} fixes, {part.length_m:.0f} m, {recording.time_s[-1]:.0f} s", *notes
    )
    if options.jitters:
        spread(part, options.max_points, options.jitters)
        return
    columns = ["route", "points", "recorded to planned, m", "planned to recorded, m"]
    columns += ["recorded to predicted, m", "predicted to recorded, m", "position error, m", "lasts, s"]
    print(f"\n| {' | '.join([*columns, 'computed in, s'])} |")
    print("|" + " --- |" * (len(columns) + 1))
    for name, reducer in reducers().items():
        begin = time.process_time()
        kept = reducer(recording.north_east_m, options.max_points)
        reduced(name, recording, kept, time.process_time() - begin)
    fitted("fit", part, options.max_points, None)
    fitted("fit, recorded speed", part, options.max_points, RECORDED)


if __name__ == "__main__":
    main()
