"""dronekit-sitl's ArduCopter binaries: its cache, and a safe download into it.

dronekit-sitl downloads over plain http without a time limit, takes a broken download for a good one,
and unpacks files outside its folder if the archive says so. Only its addresses are used here. Nobody
publishes a checksum of its binaries, so that the one of each download is told.
"""

from __future__ import annotations

import contextlib
import gzip
import http.client
import platform
import shutil
import sys
import tarfile
import tempfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from flight_replay.events import Listener, Notice, ignore
from flight_replay.exceptions import SimulatorError
from flight_replay.vehicle.sitl.fetch import fetch
from flight_replay.vehicle.sitl.unpack import unpack

_BASE_URL = "https://dronekit-assets.s3.amazonaws.com/sitl"
_CACHE = Path("~/.dronekit/sitl")
"""dronekit_sitl.sitl_host and sitl_target; the package cannot be imported on Python 3.14 and later."""
_SYSTEM, _VERSION = "copter", "3.3"  # What dronekit_sitl.start_default() flies.
_SILENCE_S = 8.0
_LIMIT_S = 120.0
_DOWNLOAD_ERRORS = (
    OSError, EOFError, ValueError, tarfile.TarError, zlib.error, http.client.HTTPException,
)  # fmt: skip
"""Errors that faulty servers and archives cause in Python's libraries."""
_PLATFORMS = {"linux": "linux", "darwin": "osx", "win32": "win"}
_MACHINES = frozenset({"x86_64", "amd64", "i386", "i686"})


@dataclass(frozen=True, slots=True)
class DownloadSource:
    """Where the binaries are downloaded from and stored; ``target`` is the platform in their names.

    ``sha256`` of the archive, in hexadecimal, is None where it is not known.
    """

    base_url: str
    cache: Path
    target: str
    sha256: str | None = None

    @property
    def url(self) -> str:
        """The address of the archive for this platform."""
        return f"{self.base_url}/{_SYSTEM}/sitl-{self.target}-{_SYSTEM}-{_VERSION}.tar.gz"

    @property
    def folder(self) -> Path:
        """The folder in which dronekit-sitl unpacks it."""
        return self.cache / f"{_SYSTEM}-{_VERSION}"

    def cached(self) -> Path | None:
        """The binary, if it was downloaded before."""
        return _binary_in(self.folder)


def _binary_in(folder: Path) -> Path | None:
    binaries = (folder / name for name in ("apm", "apm.exe"))
    return next((path for path in binaries if path.is_file()), None)


def dronekit_sitl_source() -> DownloadSource:
    """dronekit-sitl's addresses for this machine, over https.

    Raises:
        SimulatorError: dronekit-sitl has no binaries for this machine, or the user has no home folder.
    """
    target = _PLATFORMS.get(sys.platform)
    if target is None or platform.machine().lower() not in _MACHINES:
        raise SimulatorError(
            f"dronekit-sitl has no binary for {platform.system()} on {platform.machine()}; "
            "name one with --sitl"
        )
    try:
        cache = _CACHE.expanduser()
    except RuntimeError as error:
        raise SimulatorError(f"no folder for {_CACHE}: set HOME, or name a binary with --sitl") from error
    return DownloadSource(_BASE_URL, cache, target)


def download(
    source: DownloadSource,
    listener: Listener = ignore,
    *,
    limit_s: float = _LIMIT_S,
    silence_s: float = _SILENCE_S,
) -> Path:
    """Download and unpack the binary; it appears in the cache complete or not at all.

    Raises:
        SimulatorError: The download fails or is too slow, or the archive is another one, broken or unsafe.
    """
    listener(Notice(f"Downloading ArduPilot SITL (ArduCopter {_VERSION}) from {source.url}"))
    try:
        source.cache.mkdir(parents=True, exist_ok=True)
        with _scratch(source.cache) as scratch:
            archive = scratch / "sitl.tar.gz"
            sha256 = fetch(source.url, archive, listener, limit_s=limit_s, silence_s=silence_s)
            _check_sha256(sha256, source, listener)
            unpacked = scratch / "unpacked"
            unpack(archive, unpacked)
            return _install(unpacked, source, scratch)
    except _DOWNLOAD_ERRORS as error:
        raise SimulatorError(
            f"cannot download ArduPilot SITL from {source.url}: {_reason(error)}; name a binary with --sitl"
        ) from error


def _check_sha256(sha256: str, source: DownloadSource, listener: Listener) -> None:
    """Compare the hash with the known one, or tell it."""
    if source.sha256 is None:
        listener(Notice(f" No SHA-256 is known for this file; it has {sha256}"))
    elif sha256 != source.sha256.lower():
        raise OSError(f"its SHA-256 is {sha256}, not {source.sha256}: it is another file")


def _reason(error: Exception) -> str:
    """The error on one line."""
    return "not an archive" if isinstance(error, gzip.BadGzipFile) else " ".join(str(error).split())


def _install(unpacked: Path, source: DownloadSource, scratch: Path) -> Path:
    """Move the unpacked folder into the cache; the path of the binary there.

    A folder without a binary, which an interrupted download of dronekit-sitl leaves behind, is
    replaced. A folder with one is kept: another run was faster.
    """
    binary = _binary_in(unpacked)
    if binary is None:
        raise SimulatorError(f"the archive {source.url} contains no simulator; name a binary with --sitl")
    binary.chmod(0o755)
    if source.folder.exists() and source.cached() is None:
        source.folder.replace(scratch / "broken")
    try:
        unpacked.replace(source.folder)
    except OSError:
        if source.cached() is None:
            raise
    return source.folder / binary.name


@contextlib.contextmanager
def _scratch(folder: Path) -> Iterator[Path]:
    scratch = Path(tempfile.mkdtemp(prefix=".download-", dir=folder))
    try:
        yield scratch
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
