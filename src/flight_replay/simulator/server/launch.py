"""Runs the built-in copter for the length of a ``with`` block."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from flight_replay.exceptions import SimulatorError
from flight_replay.simulator.autopilot.faults import Faults
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.server.settings import Settings

_STOP_TIMEOUT_S = 5.0


@dataclass(frozen=True, slots=True)
class RunningCopter:
    """A built-in copter that is running, and its connection strings; DroneKit understands the first."""

    addresses: tuple[str, ...]
    process_id: int

    @property
    def connection(self) -> str:
        """The connection string."""
        return self.addresses[0]


@contextlib.contextmanager
def run(
    start: Start,
    *,
    speedup: float = 1.0,
    listen: Sequence[str] = ("tcp:127.0.0.1:0",),
    parameters: Mapping[str, float] | None = None,
    faults: Faults | None = None,
) -> Iterator[RunningCopter]:
    """Run the built-in copter in a process of its own until the block ends.

    Args:
        start: position on the ground, and heading.
        speedup: how many times faster than real time it runs.
        listen: addresses, port 0 for any free one; by default one TCP port on loopback.
        parameters: values by ArduPilot's names, where they differ from the defaults.
        faults: what is wrong with it.

    Raises:
        SimulatorError: if it does not start; the message says why.
    """
    values = {**(parameters or {}), "SIM_SPEEDUP": speedup}
    settings = Settings(start, tuple(listen), values, faults or Faults())
    process = subprocess.Popen(
        [sys.executable, "-m", "flight_replay.simulator.server.child"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        # Ctrl-C at the terminal must not reach it, not even while it is imported: the copter flies RTL first.
        start_new_session=True,
    )
    try:
        yield _started(process, settings)
    finally:
        _stop(process)


def _started(process: subprocess.Popen[str], settings: Settings) -> RunningCopter:
    assert process.stdin is not None
    assert process.stdout is not None
    with contextlib.suppress(BrokenPipeError):
        process.stdin.write(settings.as_line())
        process.stdin.flush()
    line = process.stdout.readline()
    if not line:
        raise SimulatorError(
            f"the built-in copter ended with status {process.wait()} while starting; see its messages above"
        )
    answer = json.loads(line)
    if "error" in answer:
        raise SimulatorError(str(answer["error"]))
    return RunningCopter(tuple(answer["addresses"]), process.pid)


def _stop(process: subprocess.Popen[str]) -> None:
    """End the process by closing its stdin; kill it if that takes too long."""
    assert process.stdin is not None
    assert process.stdout is not None
    with contextlib.suppress(OSError):
        process.stdin.close()
    try:
        process.wait(_STOP_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    process.stdout.close()
