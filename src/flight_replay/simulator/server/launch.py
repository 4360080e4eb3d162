"""Starts and stops a built-in copter for the length of a ``with`` block."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from flight_replay.errors import SimulatorError
from flight_replay.simulator.autopilot.faults import Faults
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.server.settings import Settings

_STOPS_WITHIN_S = 5.0


@dataclass(frozen=True, slots=True)
class Running:
    """A simulator that runs: connection strings, the first as DroneKit takes it."""

    addresses: tuple[str, ...]
    process_id: int

    @property
    def connection(self) -> str:
        """Where to connect to."""
        return self.addresses[0]


@contextlib.contextmanager
def run(
    start: Start,
    *,
    speedup: float = 1.0,
    listen: Sequence[str] = ("tcp:127.0.0.1:0",),
    parameters: Mapping[str, float] | None = None,
    faults: Faults | None = None,
) -> Iterator[Running]:
    """Run the built-in copter in a process of its own while the block lasts.

    Args:
        start: where it stands.
        speedup: vehicle seconds per second.
        listen: links, port 0 for any free one; the default is one TCP port on loopback.
        parameters: ArduPilot names to values that differ from the defaults.
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
    )
    try:
        yield _started(process, settings)
    finally:
        _stop(process)


def _started(process: subprocess.Popen[str], settings: Settings) -> Running:
    assert process.stdin is not None
    assert process.stdout is not None
    with contextlib.suppress(BrokenPipeError):
        process.stdin.write(settings.as_line())
        process.stdin.flush()
    line = process.stdout.readline()
    if not line:
        raise SimulatorError(
            f"the built-in copter ended with status {process.wait()} while starting; see its last words above"
        )
    answer = json.loads(line)
    if "error" in answer:
        raise SimulatorError(str(answer["error"]))
    return Running(tuple(answer["addresses"]), process.pid)


def _stop(process: subprocess.Popen[str]) -> None:
    """End the process by ending its stdin; by force if that takes too long."""
    assert process.stdin is not None
    assert process.stdout is not None
    with contextlib.suppress(OSError):
        process.stdin.close()
    try:
        process.wait(_STOPS_WITHIN_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    process.stdout.close()
