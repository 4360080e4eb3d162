"""Unpacks an archive of a stranger: nothing outside its folder, in bounded space and memory.

A few kilobytes of gzip can expand to gigabytes, of files or of tar's own headers, which Python's tarfile
reads into memory whole.
"""

from __future__ import annotations

import gzip
import shutil
import tarfile
from pathlib import Path, PurePosixPath
from typing import IO, Any

_CHUNK = 1 << 16
_LARGEST_BYTES = 1 << 28
_LARGEST_HEADER_BYTES = 1 << 20
_MAX_MEMBERS = 1000


class _SmallReads:
    """A file for tarfile, which reads a header whole, at once or in parts, however large it says it is.

    Before each piece of a member's content it seeks; within a header it does not.
    """

    def __init__(self, file: IO[bytes]) -> None:
        self._file, self._read_bytes = file, 0
        self.tell = file.tell

    def seek(self, offset: int, whence: int = 0) -> int:
        """Go somewhere else: what is read from there is something else."""
        self._read_bytes = 0
        return self._file.seek(offset, whence)

    def read(self, size: int = -1) -> bytes:
        """At most one megabyte from one place on.

        Raises:
            TarError: More is asked for.
        """
        self._read_bytes += size
        if size < 0 or self._read_bytes > _LARGEST_HEADER_BYTES:
            raise tarfile.TarError("a header of the archive is too large")
        return self._file.read(size)


def unpack(archive: Path, folder: Path) -> None:
    """Unpack plain files and folders of a ``.tar.gz``, none of them outside ``folder``.

    Raises:
        TarError: The archive is unsafe or too large.
        OSError: It is damaged, or the disk is full.
    """
    folder.mkdir()
    plain = archive.with_suffix(".plain")
    with gzip.open(archive) as packed, plain.open("w+b") as file:
        while chunk := packed.read(_CHUNK):  # To the end, where the checksum is.
            if file.tell() + len(chunk) > _LARGEST_BYTES:
                raise tarfile.TarError("the archive is too large to be a simulator")
            file.write(chunk)
        file.seek(0)
        reads: Any = _SmallReads(file)
        with tarfile.open(fileobj=reads, mode="r:") as tar:
            _extract(tar, folder)


def _extract(tar: tarfile.TarFile, folder: Path) -> None:
    size = 0
    for number, member in enumerate(tar):
        size += member.size
        if member.issparse() or size > _LARGEST_BYTES or number >= _MAX_MEMBERS:
            raise tarfile.TarError("the archive is too large to be a simulator")
        place = _place(member, folder)
        if member.isdir():
            place.mkdir(parents=True, exist_ok=True)
        elif member.isfile() and (content := tar.extractfile(member)) is not None:
            place.parent.mkdir(parents=True, exist_ok=True)
            with content, place.open("wb") as file:
                shutil.copyfileobj(content, file, _CHUNK)
        else:
            raise tarfile.TarError(f"the archive entry {member.name} is neither file nor folder")


def _place(member: tarfile.TarInfo, folder: Path) -> Path:
    """Where a member belongs.

    Raises:
        TarError: Outside the folder, or Python's own filter, which early versions of 3.10 lack, refuses it.
    """
    name = PurePosixPath(member.name.replace("\\", "/"))
    if name.is_absolute() or ".." in name.parts or ":" in member.name:
        raise tarfile.TarError(f"the archive would write outside its folder: {member.name}")
    if hasattr(tarfile, "data_filter") and (member.isfile() or member.isdir()):
        tarfile.data_filter(member, str(folder))
    return folder.joinpath(*name.parts)
