"""Reading DataFlash logs: ours against pymavlink's DFReader and mavlogdump.py, on the same bytes.

    python benchmarks/read_dataflash.py [LOG] [--only NAMES] [--megabytes N] [--runs N] [--skip-slow]

Makes a big log of a small one (default: the flight in ``tests/data/dataflash``) in a temporary
directory: its formats once, and its other records again and again, with times that go on. Each reader
is a whole process on one core; they run in turns, and the best time of each counts. Ours makes a track
of it; the others only give the records of POS, GPS, ATT, XKF1, EV and ARM, one by one. Memory is the
most that a process held, the file included where a reader maps it. ``--only POS`` makes a log of
positions alone.
"""

from __future__ import annotations

import argparse
import gzip
import io
import os
import subprocess
import sys
import sysconfig
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flight_replay.logs.byte_source import OpenLog
from flight_replay.logs.dataflash.record_formats import FMT_LENGTH, FMT_TYPE, HEADER
from flight_replay.logs.dataflash.record_stream import RecordStream

SAMPLE = Path(__file__).resolve().parents[1] / "tests" / "data" / "dataflash" / "square.bin.gz"
TYPES = ["POS", "GPS", "ATT", "XKF1", "EV", "ARM"]
BYTES_A_FIX = 80
BARE = "import numpy"
# A process is told its own peak: what the system tells of an ended one counts what it was forked from.
PEAK = """
import atexit
def peak():
    import os
    status = open("/proc/self/status").read() if os.path.exists("/proc/self/status") else "VmHWM: 0"
    os.write(2, b"\\n" + status.split("VmHWM:")[1].split()[0].encode())
atexit.register(peak)
"""
DUMP = """
import runpy, sys
sys.argv = sys.argv[1:]
runpy.run_path(sys.argv[0], run_name="__main__")
"""
OURS = """
import sys
from flight_replay.logs.read_log import read_log
print(len(read_log(sys.argv[1]).track))
"""
DFREADER = f"""
import sys
from pymavlink import DFReader
log = DFReader.DFReader_binary(sys.argv[1])
records = 0
while log.recv_match(type={TYPES}) is not None:
    records += 1
print(records)
"""


@dataclass
class Reader:
    """A program that reads a log, the shortest time of its runs, and the most memory of one."""

    name: str
    code: str
    arguments: list[str]
    taken_s: float = float("inf")
    peak_mb: float = 0.0
    printed: str = ""

    def run(self) -> None:
        """Run it once, on one core."""
        begin = time.perf_counter()
        command = [sys.executable, "-c", PEAK + self.code, *self.arguments]
        with tempfile.TemporaryFile() as told:
            with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=told) as process:
                assert process.stdout is not None
                for line in process.stdout:
                    self.printed = line.decode().strip()
            if process.returncode:
                raise SystemExit(f"{self.name} failed")
            self.taken_s = min(self.taken_s, time.perf_counter() - begin)
            told.seek(0)
            self.peak_mb = max(self.peak_mb, int(told.read().split()[-1]) * 1024 / 1e6)


def keep_to_one_core() -> None:
    """Keep this process, and those that it starts, to one core."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def build(small: bytes, size: int, target: Path, names: set[str]) -> None:
    """A log of that size: the formats of a small one, and its records (of some names) with later times."""
    body = repeatable(small, names)
    data = np.frombuffer(body.data, np.uint8).copy()
    step_us = int(body.time_us.max() - body.time_us.min()) + 100_000
    times = np.ndarray((len(data) - 7,), "<u8", data, strides=(1,))  # eight bytes from each byte on
    with target.open("wb") as big:
        big.write(body.formats)
        for copy in range(max((size - len(body.formats)) // len(data), 1)):
            times[body.time_at] = body.time_us + np.uint64(copy * step_us)
            big.write(data.tobytes())


@dataclass(frozen=True)
class Body:
    """A log's formats, its other records, and where in these the times are."""

    formats: bytes
    data: bytes
    time_at: np.ndarray
    time_us: np.ndarray


def repeatable(small: bytes, names: set[str]) -> Body:
    """A log in parts: FMT is told once, and the times of all other records can be moved."""
    stream = RecordStream(OpenLog("small", io.BytesIO(small)), ())
    for _ in stream.blocks():
        pass
    formats = stream.formats
    at, own, others, time_at = 0, [], bytearray(), []
    while at < len(small):
        kind = small[at + 2] if small.startswith(HEADER, at) and at + 2 < len(small) else -1
        length = int(formats.lengths[kind]) if kind >= 0 else 0
        if not length or at + length > len(small):
            at += 1
            continue
        record = small[at : at + length]
        if kind == FMT_TYPE and length == FMT_LENGTH:
            own.append(record)
        elif not names or formats.by_type[kind].name in names:
            known = formats.by_type[kind]
            if known.columns[:1] == ("TimeUS",):
                time_at.append(len(others) + 3)
            others += record
        at += length
    index = np.array(time_at)
    time_us = np.ndarray((len(others) - 7,), "<u8", bytes(others), strides=(1,))[index]
    return Body(b"".join(own), bytes(others), index, time_us)


def measure(big: Path, runs: int, skip_slow: bool) -> None:
    """Read a log with everything there is, in turns, and print times, ratios and memory."""
    dump = Path(sysconfig.get_path("scripts")) / "mavlogdump.py"
    ours = Reader("ours, a track", OURS, [str(big)])
    bare = Reader("Python and numpy alone", BARE, [])
    others = [
        Reader("DFReader recv_match(type)", DFREADER, [str(big)]),
        Reader("mavlogdump.py --types", DUMP, [str(dump), "--types", ",".join(TYPES), str(big)]),
    ]
    readers = [bare, ours, *([] if skip_slow else others)]
    for _ in range(runs):
        for reader in readers:
            reader.run()
    print(f"{big.stat().st_size / 1e6:.0f} MB, best of {runs}, whole processes on one core:")
    for reader in readers:
        times = reader.taken_s / ours.taken_s
        print(f"  {reader.name:26} {reader.taken_s:8.3f} s  {times:6.1f} times ours {reader.peak_mb:7.0f} MB")
    above_mb = ours.peak_mb - bare.peak_mb
    fixes = int(ours.printed)
    print(f"{fixes} fixes; memory {above_mb:.0f} MB above Python and numpy,")
    print(f"  {above_mb - fixes * BYTES_A_FIX / 1e6:.0f} MB besides {BYTES_A_FIX} bytes a fix")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("log", nargs="?", type=Path, default=SAMPLE)
    parser.add_argument("--only", default="", metavar="NAMES", help="records to leave in, such as POS,ARM")
    parser.add_argument("--megabytes", type=int, default=250)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--skip-slow", action="store_true", help="leave out pymavlink and mavlogdump.py")
    options = parser.parse_args()
    data = options.log.read_bytes()
    with tempfile.TemporaryDirectory() as name:
        big = Path(name) / "big.bin"
        small = gzip.decompress(data) if data[:2] == b"\x1f\x8b" else data
        build(small, options.megabytes * 10**6, big, set(filter(None, options.only.split(","))))
        keep_to_one_core()
        measure(big, options.runs, options.skip_slow)


if __name__ == "__main__":
    main()
