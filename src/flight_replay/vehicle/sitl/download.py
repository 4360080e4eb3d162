"""dronekit-sitl's ArduCopter binaries: its cache, and a safe download into it.

dronekit-sitl downloads over plain http without a time limit, takes a broken download for a good one,
and unpacks files outside its folder if the archive says so. Only its addresses are used here.
"""

from __future__ import annotations

import contextlib
import http.client
import lzma
import platform
import shutil
import socket
import sys
import tarfile
import tempfile
import time
import urllib.error
import urllib.parse
import urllib.request
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from flight_replay.errors import SimulatorError
from flight_replay.events import Listener, Progress, ignore
from flight_replay.vehicle.link.host_lookup import look_up

_BASE_URL = "https://dronekit-assets.s3.amazonaws.com/sitl"
_CACHE = Path("~/.dronekit/sitl")
"""dronekit_sitl.sitl_host and sitl_target; the package cannot be imported on Python 3.14 and later."""
_SYSTEM, _VERSION = "copter", "3.3"  # What dronekit_sitl.start_default() flies.
_SILENCE_S = 8.0
_LIMIT_S = 120.0
_CHUNK = 1 << 16
_LARGEST_BYTES = 1 << 29
_DOWNLOAD_ERRORS = (
    OSError, EOFError, ValueError, tarfile.TarError, zlib.error, lzma.LZMAError, http.client.HTTPException,
)  # fmt: skip
"""Errors that faulty servers and archives cause in Python's libraries."""
_PLATFORMS = {"linux": "linux", "darwin": "osx", "win32": "win"}
_MACHINES = frozenset({"x86_64", "amd64", "i386", "i686"})


@dataclass(frozen=True, slots=True)
class DownloadSource:
    """Where the binaries are downloaded from and stored; ``target`` is the platform in their names."""

    base_url: str
    cache: Path
    target: str

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
        SimulatorError: The download fails or is too slow, or the archive is broken or unsafe.
    """
    try:
        source.cache.mkdir(parents=True, exist_ok=True)
        with _scratch(source.cache) as scratch:
            archive = scratch / "sitl.tar.gz"
            _fetch(source.url, archive, listener, time.monotonic() + limit_s, silence_s)
            unpacked = scratch / "unpacked"
            _unpack(archive, unpacked)
            return _install(unpacked, source, scratch)
    except _DOWNLOAD_ERRORS as error:
        raise SimulatorError(
            f"cannot download ArduPilot SITL from {source.url}: {_reason(error)}; name a binary with --sitl"
        ) from error


def _reason(error: Exception) -> str:
    """The error on one line; tarfile writes a line for each compression that it tried."""
    no_archive = isinstance(error, tarfile.ReadError) and "\n" in str(error)
    return "not an archive" if no_archive else " ".join(str(error).split())


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


def _fetch(url: str, path: Path, listener: Listener, end_s: float, silence_s: float) -> None:
    """Download an address to a file, completely and in time."""
    _resolve(url, silence_s)
    with _answer(url, silence_s) as answer, path.open("wb") as file:
        total = int(answer.headers.get("Content-Length") or 0)
        done = 0
        # read1, because read waits for a whole chunk, however slow the server is.
        while chunk := answer.read1(_CHUNK):
            done += file.write(chunk)
            if time.monotonic() > end_s:
                raise TimeoutError("the download takes too long")
            if done > _LARGEST_BYTES:
                raise OSError("the file is too large to be a simulator")
            listener(Progress("ArduPilot SITL", done, total, "bytes"))
    if total and done != total:
        raise OSError(f"the download ended after {done} of {total} bytes")


def _answer(url: str, silence_s: float) -> http.client.HTTPResponse:
    """The open answer of a server.

    Raises:
        HTTPError: The server refuses; its answer is closed, which the error would leave open.
    """
    try:
        answer: http.client.HTTPResponse = urllib.request.build_opener().open(url, timeout=silence_s)
    except urllib.error.HTTPError as error:
        error.close()
        raise
    return answer


def _resolve(url: str, limit_s: float) -> None:
    """Check in time that the host name resolves; a proxy resolves it itself."""
    parts = urllib.parse.urlsplit(url)
    if parts.scheme in urllib.request.getproxies():
        return
    try:
        look_up(parts.hostname or "", parts.port or parts.scheme, limit_s)
    except socket.gaierror as error:
        raise OSError(f"unknown host name {parts.hostname}") from error


def _unpack(archive: Path, folder: Path) -> None:
    """Unpack plain files and folders, none of them outside ``folder``."""
    folder.mkdir()
    with tarfile.open(archive) as tar:
        for member in tar:
            name = PurePosixPath(member.name.replace("\\", "/"))
            if name.is_absolute() or ".." in name.parts or ":" in member.name:
                raise tarfile.TarError(f"the archive would write outside its folder: {member.name}")
            place = folder.joinpath(*name.parts)
            if member.isdir():
                place.mkdir(parents=True, exist_ok=True)
            elif member.isfile() and (content := tar.extractfile(member)) is not None:
                place.parent.mkdir(parents=True, exist_ok=True)
                with content, place.open("wb") as file:
                    shutil.copyfileobj(content, file)
            else:
                raise tarfile.TarError(f"the archive entry {member.name} is neither file nor folder")
        while tar.fileobj and tar.fileobj.read(_CHUNK):
            continue  # To the end, where the checksum is.
