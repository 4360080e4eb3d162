"""Where an ArduCopter SITL binary may be: named, in ``SITL_BINARY``, on PATH, or in dronekit-sitl's cache."""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from flight_replay.errors import SimulatorError
from flight_replay.vehicle.sitl.download import Source

_ON_PATH = "arducopter"


@dataclass(frozen=True, slots=True)
class Binary:
    """A simulator to run; ``defaults`` is a parameter file, ``named`` tells that the user asked for it."""

    path: Path
    defaults: Path | None = None
    named: bool = False


def at_hand(
    path: Path | None, source: Source | None, environment: Mapping[str, str] = os.environ
) -> Binary | None:
    """The binary to run, without downloading anything; None if there is none.

    Args:
        path: The binary named with ``--sitl``.
        source: Where dronekit-sitl keeps and gets its binaries; None if that is not installed.
        environment: ``SITL_BINARY`` and ``SITL_DEFAULTS_FILEPATH`` count, as for dronekit-sitl, and PATH.

    Raises:
        SimulatorError: A file that the user named is missing, or cannot be run.
    """
    defaults = _defaults(environment)
    if path is not None:
        return Binary(_runnable(path, "--sitl"), defaults, named=True)
    if environment.get("SITL_BINARY"):
        return Binary(_runnable(Path(environment["SITL_BINARY"]), "SITL_BINARY"), defaults, named=True)
    found = shutil.which(_ON_PATH, path=environment.get("PATH", ""))
    if found:
        return Binary(Path(found), defaults)
    if source is not None and (cached := source.cached()) is not None:
        return Binary(cached, defaults)
    return None


def _defaults(environment: Mapping[str, str]) -> Path | None:
    named = environment.get("SITL_DEFAULTS_FILEPATH")
    if not named:
        return None
    # ArduPilot takes several files, with commas between them.
    for part in named.split(","):
        if not Path(part).is_file():
            raise SimulatorError(f"the parameter file {part} named in SITL_DEFAULTS_FILEPATH does not exist")
    return Path(named)


def _runnable(path: Path, where: str) -> Path:
    if not path.is_file():
        raise SimulatorError(f"the SITL binary {path} named by {where} does not exist; check the path")
    if not os.access(path, os.X_OK):
        raise SimulatorError(f"{path}, named by {where}, cannot be run; make it executable: chmod +x {path}")
    return path.resolve()
