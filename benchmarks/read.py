"""Reading positions: ours against grep, pymavlink, mavlogdump and MAVLink's C parser, on the same bytes.

    python benchmarks/read.py [LOG] [--copies N] [--large MEGABYTES] [--runs N] [--skip-slow]

Builds a big log out of copies of a small one (default: the sample flight, 100 times) in a
temporary directory and reads it with each, one after the other, several times; the best time of
each counts. Ours is timed in a process that has started already, and as a whole process too.
Last it reads a log of ``--large`` megabytes and prints how much memory that took at most, above
what Python and numpy take by themselves.
"""

from __future__ import annotations

import argparse
import contextlib
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

SAMPLE = Path(__file__).resolve().parents[1] / "data" / "flight.tlog"
BYTES_A_FIX = 72
C_SOURCE = """
#include <stdio.h>
#include "ardupilotmega/mavlink.h"
int main(int argc, char **argv) {
    static unsigned char buffer[1 << 16];
    FILE *file = fopen(argv[argc - 1], "rb");
    mavlink_message_t message;
    mavlink_status_t status;
    long positions = 0;
    double sum = 0;
    size_t length;
    while ((length = fread(buffer, 1, sizeof buffer, file)) > 0)
        for (size_t at = 0; at < length; at++)
            if (mavlink_parse_char(MAVLINK_COMM_0, buffer[at], &message, &status) && message.msgid == 33) {
                mavlink_global_position_int_t position;
                mavlink_msg_global_position_int_decode(&message, &position);
                sum += position.lat;
                positions++;
            }
    printf("%ld positions (%g)\\n", positions, sum);
    return 0;
}
"""
OURS = """
import sys, time
from flight_replay.logs.read_log import read_log
best = 1e9
for _ in range(int(sys.argv[2])):
    start = time.perf_counter()
    log = read_log(sys.argv[1])
    best = min(best, time.perf_counter() - start)
print(best, len(log.track))
"""
BARE = "import numpy, time; time.sleep(0.5)"
PYMAVLINK = """
import sys
from pymavlink import mavutil
log = mavutil.mavlink_connection(sys.argv[1])
positions = 0
while log.recv_match(type="GLOBAL_POSITION_INT") is not None:
    positions += 1
print(positions, "positions")
"""


def python(code: str, *arguments: str) -> str:
    """What a Python process of its own prints."""
    return _output([sys.executable, "-c", code, *arguments])


def _output(command: list[str]) -> str:
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode > 1:  # grep says 1 when it finds nothing
        raise SystemExit(f"{command[0]} failed")
    return done.stdout.strip()


def best_s(run: Callable[[], object], runs: int) -> float:
    """The shortest of several times, seconds."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times)


def build(small: Path, copies: int, target: Path) -> Path:
    """A log that holds another one several times."""
    data = small.read_bytes()
    with target.open("wb") as big:
        for _ in range(copies):
            big.write(data)
    return target


def c_parser(directory: Path) -> list[str] | None:
    """A program around MAVLink's C parser, made by pymavlink's generator and the C compiler at hand."""
    compiler = shutil.which("cc")
    if compiler is None:
        return None
    from pymavlink import dialects
    from pymavlink.generator import mavgen

    definitions = Path(dialects.__file__).parent / "v20" / "ardupilotmega.xml"
    options = mavgen.Opts(str(directory / "include"), wire_protocol="2.0", language="C", validate=False)
    with contextlib.redirect_stdout(None):
        mavgen.mavgen(options, [str(definitions)])
    source, program = directory / "parser.c", directory / "parser"
    source.write_text(C_SOURCE)
    command = [
        compiler,
        "-O2",
        "-w",
        "-I",
        str(directory / "include"),
        str(source),
        "-o",
        str(program),
        "-lm",
    ]
    subprocess.run(command, check=True)
    return [str(program)]


def measure(big: Path, directory: Path, runs: int, skip_slow: bool) -> None:
    """Read one log with everything there is and print the times and their ratios."""
    mega = big.stat().st_size / 1e6
    ours_s = grep_s = 1e9
    for _ in range(runs):  # in turns, for whatever else the machine does meets both
        ours_s = min(ours_s, float(python(OURS, str(big), "3").split()[0]))
        grep_s = min(grep_s, best_s(lambda: _output(["grep", "-c", "-F", "flight-replay", str(big)]), 3))
    print(f"{big.name}: {mega:.0f} MB")
    show("ours", ours_s, ours_s)
    show("ours, the whole process", best_s(lambda: python(OURS, str(big), "1"), runs), ours_s)
    show("grep -c of a fixed string", grep_s, ours_s)
    if (parser := c_parser(directory)) is not None:
        show("C parser by mavgen", best_s(lambda: _output([*parser, str(big)]), runs), ours_s)
    if not skip_slow:
        show("pymavlink recv_match(type)", best_s(lambda: python(PYMAVLINK, str(big)), 1), ours_s)
        dump = Path(sysconfig.get_path("scripts")) / "mavlogdump.py"
        command = [sys.executable, str(dump), "--types", "GLOBAL_POSITION_INT", str(big)]
        dumped_s = best_s(lambda: subprocess.run(command, stdout=subprocess.DEVNULL, check=True), 1)
        show("mavlogdump.py --types", dumped_s, ours_s)
    print(f"grep's time over ours: {grep_s / ours_s:.2f} (ours over grep's: {ours_s / grep_s:.2f})")


def show(name: str, taken_s: float, ours_s: float) -> None:
    print(f"  {name:28} {taken_s:8.3f} s  {taken_s / ours_s:7.1f} times ours")


def memory(large: Path) -> None:
    """Read a large log and print the peak of memory above the interpreter's own."""
    _, bare_kib = peak([sys.executable, "-c", BARE])
    printed, peak_kib = peak([sys.executable, "-c", OURS, str(large), "1"])
    taken_s, fixes = printed.split()
    above_mb = (peak_kib - bare_kib) * 1024 / 1e6
    beside_mb = above_mb - int(fixes) * BYTES_A_FIX / 1e6
    print(f"{large.name}: {large.stat().st_size / 1e6:.0f} MB, {int(fixes)} fixes, {float(taken_s):.3f} s")
    print(f"  peak memory {above_mb:.0f} MB above Python's and numpy's {bare_kib * 1024 / 1e6:.0f} MB:")
    print(f"  {beside_mb:.0f} MB besides {BYTES_A_FIX} bytes a fix")


def peak(command: list[str]) -> tuple[str, int]:
    """What a program prints, and the most memory that it and its children had together, KiB.

    Shared pages count once, by the share that Linux gives each process (Pss).
    """
    most_kib = 0
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        while process.poll() is None:
            most_kib = max(most_kib, _memory_kib(process.pid))
            time.sleep(0.002)
        assert process.stdout is not None
        return process.stdout.read(), most_kib


def _memory_kib(pid: int) -> int:
    """The memory of a process and its children; what has ended meanwhile has none."""
    try:
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    except OSError:
        return 0
    own_kib = sum(int(line.split()[1]) for line in lines if line.startswith("Pss:"))
    return own_kib + sum(_memory_kib(int(child)) for child in children)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("log", nargs="?", type=Path, default=SAMPLE)
    parser.add_argument("--copies", type=int, default=100)
    parser.add_argument("--large", type=int, default=1000, help="megabytes of the log read for its memory")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--skip-slow", action="store_true", help="leave out pymavlink and mavlogdump.py")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        directory = Path(name)
        big = build(options.log, options.copies, directory / "big.tlog")
        measure(big, directory, options.runs, options.skip_slow)
        big.unlink()
        copies = max(options.large * 1_000_000 // options.log.stat().st_size, 1)
        memory(build(options.log, copies, directory / "large.tlog"))


if __name__ == "__main__":
    main()
