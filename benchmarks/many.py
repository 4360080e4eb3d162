"""How fast an archive is planned: flight-replay-many with one worker, with two, and a shell loop.

    python benchmarks/many.py [LOGS [LOOPED]]

The logs (by default 200) are parts of the sample: cut anywhere, moved elsewhere, damaged, and every fiftieth
is no log at all. A loop of ``flight-replay --dry-run --json`` over the first of them (by default 40) is what
people have today. Each is run with the options that both have in common; what is printed are logs a
second, their ratio to the loop, and the most memory that the program itself took, its workers aside.
"""

from __future__ import annotations

import argparse
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from flight_replay.logs.flights import select
from flight_replay.logs.read_log import read_log
from flight_replay.logs.sample import sample_log
from flight_replay.logs.track import Track
from flight_replay.mission import formats
from flight_replay.mission.items import Mission, waypoint
from tests.helpers.mutations import flipped

SHORTEST_BYTES, LONGEST_BYTES = 300_000, 1_500_000
SHORTEST_S, LONGEST_S = 60.0, 300.0
NO_MISSION = Mission((waypoint(0.0, 0.0, 30.0),))
_POLL_S = 0.1


def make_logs(folder: Path, count: int) -> list[Path]:
    """Write logs, no two of one content."""
    sample, chance = sample_log().read_bytes(), random.Random(18)
    track = read_log(sample_log()).track
    paths = []
    for number in range(count):
        kind = "junk" if number % 50 == 49 else ("cut", "moved", "damaged")[number % 3]
        path = folder / f"{number:05}-{kind}.{'csv' if kind == 'moved' else 'tlog'}"
        path.write_bytes(content(kind, sample, track, chance))
        paths.append(path)
    return paths


def content(kind: str, sample: bytes, track: Track, chance: random.Random) -> bytes:
    """The bytes of a log of one kind."""
    if kind == "junk":
        return chance.randbytes(100_000)
    if kind == "moved":
        begin_s = chance.uniform(0.0, track.time_s[-1] - track.time_s[0] - LONGEST_S)
        part = select(track, from_s=begin_s, to_s=begin_s + chance.uniform(SHORTEST_S, LONGEST_S))
        return formats.csv_table.text(NO_MISSION, moved(part, chance)).encode()
    length = chance.randint(SHORTEST_BYTES, LONGEST_BYTES)
    begin = chance.randint(0, len(sample) - length)
    part_of = sample[begin : begin + length]
    return part_of if kind == "cut" else flipped(part_of, np.random.default_rng(chance.getrandbits(32)), [])


def moved(track: Track, chance: random.Random) -> Track:
    """The same flight at another place on earth."""
    columns = {name: getattr(track, name) for name in track.__dataclass_fields__}
    columns["lat_deg"] = track.lat_deg + chance.uniform(-40.0, 10.0)
    columns["lon_deg"] = track.lon_deg + chance.uniform(-90.0, 90.0)
    return Track(**columns)


def run(command: list[str]) -> tuple[float, float]:
    """Seconds that a command takes, and the most memory that its own process had, in MB (Linux)."""
    begin_s, most_mb = time.monotonic(), 0.0
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        status = Path(f"/proc/{process.pid}/status")
        while process.poll() is None:
            if status.exists():
                lines = status.read_text().splitlines()
                peak = [line.split()[1] for line in lines if line.startswith("VmHWM")]
                most_mb = max([most_mb, *(float(kilobytes) / 1024 for kilobytes in peak)])
            time.sleep(_POLL_S)
    return time.monotonic() - begin_s, most_mb


def main() -> None:
    """Make the logs, and print a row for each way."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("logs", nargs="?", type=int, default=200)
    parser.add_argument("looped", nargs="?", type=int, default=40)
    options = parser.parse_args()
    count, looped = options.logs, options.looped
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "logs").mkdir()
        paths = make_logs(folder / "logs", count)
        one = [sys.executable, "-m", "flight_replay", "--dry-run", "--json"]
        loop_s = sum(run([*one, str(path)])[0] for path in paths[:looped]) / min(looped, count)
        print(f"shell loop over {min(looped, count)} logs: {1 / loop_s:.2f} logs a second")
        for workers in (1, 2):
            many = [sys.executable, "-m", "flight_replay.cli.many.many_main", str(folder / "logs"), "-q"]
            out = folder / f"{workers}.parquet"
            took_s, most_mb = run([*many, "--workers", str(workers), "--out", str(out)])
            rate = count / took_s
            print(f"{workers} workers, {count} logs: {rate:.2f} logs a second, {most_mb:.0f} MB;", end=" ")
            print(f"{rate * loop_s:.1f} times the loop")


if __name__ == "__main__":
    main()
