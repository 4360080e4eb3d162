"""What a run does with every flight, and the command that does it with one."""

from __future__ import annotations

import hashlib
import json
import shlex
from dataclasses import dataclass
from typing import Literal

FlyWith = Literal["none", "model", "builtin", "sitl"]
FLY_WITH: tuple[FlyWith, ...] = ("none", "model", "builtin", "sitl")
BY_THE_CLOCK = ("builtin", "sitl")
"""What flies in a process of its own, at the pace of a clock."""


def path_argument(log: str) -> str:
    """The path of a log as an argument that is no option."""
    return f"./{log}" if log.startswith("-") else log


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """How every flight is planned and flown.

    ``arguments`` are options of ``flight-replay``, without the log, the flight and the simulator;
    ``sitl`` is the path of an ArduPilot SITL binary, ``sitl_sha256`` its hash; ``speedup`` is how fast a
    simulator runs; ``time_limit_s`` is the time for a flight, None for one that follows from its length.
    """

    arguments: tuple[str, ...] = ()
    fly: FlyWith = "none"
    sitl: str | None = None
    sitl_sha256: str | None = None
    speedup: float | None = None
    time_limit_s: float | None = None

    @property
    def options(self) -> str:
        """The options, as a person would type them."""
        return shlex.join([*self.arguments, "--fly", self.fly, *self._sitl, *self._speedup])

    @property
    def options_id(self) -> str:
        """A hash of all that the results depend on but the log; the name of a SITL binary is not of that."""
        speedup = self.speedup if self.fly in BY_THE_CLOCK else None
        sitl = self.sitl_sha256 if self.fly == "sitl" else None
        text = json.dumps([self.arguments, self.fly, sitl, speedup])
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    @property
    def _sitl(self) -> tuple[str, ...]:
        return () if self.sitl is None else ("--sitl", self.sitl)

    @property
    def _speedup(self) -> tuple[str, ...]:
        return () if self.speedup is None else ("--speedup", f"{self.speedup:g}")

    def replay_arguments(self, log: str, system: int | None, flight: int | None) -> tuple[str, ...]:
        """The arguments of ``flight-replay`` for one flight; ``system`` where its log holds several vehicles.

        With ``--fly none`` and ``--fly model`` they end in a dry run.
        """
        how = {
            "builtin": ("--sim", "builtin", *self._speedup),
            "sitl": (*(self._sitl or ("--sim", "sitl")), *self._speedup),
        }
        return (
            path_argument(log),
            *self.arguments,
            *(() if system is None else ("--vehicle", str(system))),
            *(() if flight is None else ("--flight", str(flight))),
            *how.get(self.fly, ("--dry-run",)),
        )

    def replay_command(self, log: str, system: int | None, flight: int | None) -> str:
        """The command line that repeats what is done with one flight."""
        return shlex.join(["flight-replay", *self.replay_arguments(log, system, flight)])
