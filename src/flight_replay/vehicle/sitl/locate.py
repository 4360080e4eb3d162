"""Finds an ArduCopter SITL binary: ``--sitl``, ``SITL_BINARY``, PATH, or dronekit-sitl's cache."""

from __future__ import annotations

import os
import shlex
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from flight_replay.exceptions import SimulatorError
from flight_replay.vehicle.sitl.download import DownloadSource

_ON_PATH = "arducopter"


@dataclass(frozen=True, slots=True)
class SitlBinary:
    """A binary to run; ``defaults`` are parameter files, ``named`` is true if the user named the binary."""

    path: Path
    defaults: tuple[Path, ...] = ()
    named: bool = False


def find_binary(
    path: Path | None, source: DownloadSource | None, environment: Mapping[str, str] = os.environ
) -> SitlBinary | None:
    """The binary to run, without a download; None if there is none.

    Args:
        path: The binary named with ``--sitl``.
        source: Where dronekit-sitl stores its binaries; None if it has none for this machine.
        environment: For ``SITL_BINARY`` and ``SITL_DEFAULTS_FILEPATH``, as for dronekit-sitl, and PATH.

    Raises:
        SimulatorError: A file that the user named is missing or not executable.
    """
    defaults = _defaults(environment)
    if path is not None:
        return SitlBinary(_runnable(path, "--sitl"), defaults, named=True)
    if environment.get("SITL_BINARY"):
        return SitlBinary(_runnable(Path(environment["SITL_BINARY"]), "SITL_BINARY"), defaults, named=True)
    found = shutil.which(_ON_PATH, path=environment.get("PATH", ""))
    if found:
        return SitlBinary(Path(found), defaults)
    if source is not None and (cached := source.cached()) is not None:
        return SitlBinary(cached, defaults)
    return None


def _defaults(environment: Mapping[str, str]) -> tuple[Path, ...]:
    named = environment.get("SITL_DEFAULTS_FILEPATH")
    # ArduPilot takes several files, with commas between them.
    files = tuple(map(Path, named.split(","))) if named else ()
    for path in files:
        if not path.is_file():
            raise SimulatorError(
                f"the parameter file {path}, named by SITL_DEFAULTS_FILEPATH, does not exist; check the path"
            )
    return files


def _runnable(path: Path, where: str) -> Path:
    if path.is_dir():
        raise SimulatorError(f"{path}, named by {where}, is a folder; name the SITL binary in it")
    if not path.is_file():
        raise SimulatorError(f"the SITL binary {path}, named by {where}, does not exist; check the path")
    if not os.access(path, os.X_OK):
        raise SimulatorError(
            f"the SITL binary {path}, named by {where}, is not executable; "
            f"run: {shlex.join(['chmod', '+x', str(path)])}"
        )
    return path.resolve()
