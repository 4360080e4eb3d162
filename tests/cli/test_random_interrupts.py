"""Ctrl-C and its like at random moments of a whole run at a terminal: nothing is left, nothing is broken."""

from __future__ import annotations

import os
import pty
import random
import secrets
import select
import signal
import subprocess
import sys
import termios
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.helpers.paths import SAMPLE

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes are looked for in /proc")

CHUNKS = 6
MOMENTS_PER_CHUNK = int(os.environ.get("FLIGHT_REPLAY_MOMENTS", "5"))
"""50 make three hundred moments, a quarter of an hour."""
EXIT_WITHIN_S, ORPHANS_END_WITHIN_S = 10.0, 5.0
IMPORTS_S = 0.06
OPTIONS = [
    "--tlog", str(SAMPLE), "--sim", "builtin", "--speedup", "20",
    "--takeoff-altitude", "5", "--duration", "10",
]  # fmt: skip
HIDE, SHOW = b"\x1b[?25l", b"\x1b[?25h"


class Session:
    """A run of the program at a terminal of its own, whose output is read all the time."""

    def __init__(self, folder: Path) -> None:
        self.scratch = folder / "scratch"
        self.scratch.mkdir(exist_ok=True)
        self.mark = f"FLIGHT_REPLAY_TEST={secrets.token_hex(8)}"
        name, _, value = self.mark.partition("=")
        self.master, self.slave = pty.openpty()
        # Without NOFLSH each Ctrl-C discards what this test has not read yet, an error line for example.
        settings = termios.tcgetattr(self.slave)
        settings[3] |= termios.NOFLSH
        termios.tcsetattr(self.slave, termios.TCSANOW, settings)
        self.settings = termios.tcgetattr(self.slave)
        self.output = b""
        # The new session gets its terminal by opening it.
        opens_terminal = f'exec {sys.executable} -m flight_replay "$@" <{os.ttyname(self.slave)}'
        self.process = subprocess.Popen(
            ["sh", "-c", opens_terminal, "sh", *OPTIONS], cwd=folder, start_new_session=True,
            stdin=subprocess.DEVNULL, stdout=self.slave, stderr=self.slave,
            env={**os.environ, "TERM": "xterm", "TMPDIR": str(self.scratch), name: value},
        )  # fmt: skip
        self._over = threading.Event()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        while not self._over.is_set() or select.select([self.master], [], [], 0)[0]:
            if select.select([self.master], [], [], 0.02)[0]:
                self.output += os.read(self.master, 65536)

    def wait_until_it_handles_signals(self) -> None:
        """Before that, Python itself is starting."""
        while self.process.poll() is None:
            with suppress(OSError):
                status = Path(f"/proc/{self.process.pid}/status").read_text()
                caught = int(status.split("SigCgt:")[1].split()[0], 16)
                if caught >> (signal.SIGTERM - 1) & 1:
                    return
            time.sleep(0.0005)

    def close(self) -> None:
        """End everything."""
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self._over.set()
        self._reader.join()
        os.close(self.master)
        os.close(self.slave)

    def others(self) -> list[str]:
        """Commands of processes that the run has started."""
        found = []
        for environment in Path("/proc").glob("[0-9]*/environ"):
            with suppress(OSError):
                if self.mark.encode() in environment.read_bytes():
                    found.append((environment.parent / "cmdline").read_text().replace("\0", " "))
        return found


def ctrl_c(session: Session) -> None:
    os.write(session.master, b"\x03")


def sigterm(session: Session) -> None:
    session.process.send_signal(signal.SIGTERM)


def burst(session: Session) -> None:
    """As from an impatient person, or a terminal that is closed."""
    for number in (signal.SIGINT, signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
        session.process.send_signal(number)
        time.sleep(0.01)
    for _ in range(3):
        ctrl_c(session)
        time.sleep(0.02)


INTERRUPTS: tuple[Callable[[Session], None], ...] = (ctrl_c, sigterm, burst)


@dataclass(frozen=True)
class Ending:
    """How an interrupted run ended; ``problems`` is empty if it was as it should be."""

    moment_s: float
    exit_s: float
    finished: bool
    problems: tuple[str, ...]


def length_s(folder: Path) -> float:
    """How long a run takes that is not interrupted."""
    session = Session(folder)
    try:
        session.wait_until_it_handles_signals()
        began_s = time.monotonic()
        assert session.process.wait(120) == 0, session.output
        return time.monotonic() - began_s
    finally:
        session.close()


def interrupted(folder: Path, moment_s: float, interrupt: Callable[[Session], None]) -> Ending:
    """A run that is interrupted once, in one way, so long after it began."""
    session = Session(folder)
    try:
        session.wait_until_it_handles_signals()
        time.sleep(moment_s)
        finished = session.process.poll() is not None
        began_s = time.monotonic()
        interrupt(session)
        with suppress(subprocess.TimeoutExpired):
            session.process.wait(3 * EXIT_WITHIN_S)
        exit_s = time.monotonic() - began_s
        problems = [] if finished else list(problems_of(session, exit_s))
        return Ending(moment_s, exit_s, finished, tuple(problems))
    finally:
        session.close()


def problems_of(session: Session, exit_s: float) -> list[str]:
    """What is not as it should be after an interrupt."""
    orphans_until_s = time.monotonic() + ORPHANS_END_WITHIN_S
    while session.others() and time.monotonic() < orphans_until_s:
        time.sleep(0.02)
    time.sleep(0.05)  # The reader takes the last output.
    output = session.output
    # A signal that comes while the interpreter exits may change nothing any more.
    done = session.process.returncode == 0 and b"Position error: " in output
    problems = {
        f"status {session.process.returncode}": session.process.returncode != 130 and not done,
        f"took {exit_s:.1f} s": exit_s > EXIT_WITHIN_S,
        f"orphans {session.others()}": bool(session.others()),
        "cursor hidden": output.rfind(HIDE) > output.rfind(SHOW),
        "terminal settings": termios.tcgetattr(session.slave) != session.settings,
        "a traceback": b"Traceback" in output or b"Exception ignored" in output,
        f"files {list(session.scratch.iterdir())}": bool(list(session.scratch.iterdir())),
    }
    found = [problem for problem, is_true in problems.items() if is_true]
    return [*found, output[-3000:].decode(errors="replace")] if found else []


@pytest.mark.parametrize("interrupt", INTERRUPTS)
def test_an_interrupt_during_the_imports_is_one_line(
    tmp_path: Path, interrupt: Callable[[Session], None]
) -> None:
    """At once, or some milliseconds later: status 130 and no traceback, not from a child either."""
    for number in range(5):
        ending = interrupted(tmp_path, IMPORTS_S * number / 5, interrupt)
        assert ending.problems == ()
        assert ending.exit_s < 2 + EXIT_WITHIN_S / 5


@pytest.mark.slow
@pytest.mark.realtime
@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_an_interrupt_at_any_moment_leaves_nothing_behind(tmp_path: Path, chunk: int) -> None:
    """Status 130 in 10 s, the cursor shown, the terminal as before, no process, no file, no traceback."""
    chance = random.Random(1400 + chunk)
    length = length_s(tmp_path)
    endings: list[Ending] = []
    # A run may end before its moment: so many are interrupted, nevertheless.
    while sum(not ending.finished for ending in endings) < MOMENTS_PER_CHUNK:
        moment_s = chance.uniform(0.0, IMPORTS_S if len(endings) % 5 == 0 else length)
        endings.append(interrupted(tmp_path, moment_s, chance.choice(INTERRUPTS)))
        assert len(endings) < 2 * MOMENTS_PER_CHUNK
    failures = [ending for ending in endings if ending.problems]
    slowest_s = max(ending.exit_s for ending in endings)
    sys.stdout.write(f"{len(endings)} runs of {length:.1f} s, slowest exit {slowest_s:.2f} s\n")
    assert not failures, "\n".join(f"{each.moment_s:.3f} s: {', '.join(each.problems)}" for each in failures)
