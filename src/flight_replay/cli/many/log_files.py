"""Which logs to read: files, folders and a list on standard input."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

LOG_SUFFIXES = frozenset(
    (".tlog", ".rlog", ".bin", ".log", ".ulg", ".gpx", ".kml", ".kmz", ".csv", ".geojson")
)
"""Files of a folder that are taken for logs, packed with gzip as well; what is named is read in any case."""
_PACKED = ".gz"


@dataclass(frozen=True, slots=True)
class LogFile:
    """A log by its path; size and time are None where it could not be looked at."""

    path: str
    bytes: int | None = None
    modified_ns: int | None = None


@dataclass(slots=True)
class LogFiles:
    """What was found: every log once, in order, and how many other files, by suffix."""

    files: list[LogFile] = field(default_factory=list)
    passed_over: Counter[str] = field(default_factory=Counter)


def find_logs(paths: Sequence[str], lines: Iterable[str], written: Sequence[Path | None] = ()) -> LogFiles:
    """The logs at some paths.

    Args:
        paths: files, folders, or - for those in ``lines``.
        lines: paths, one a line.
        written: files that the run writes itself.
    """
    found = LogFiles()
    seen = {os.path.realpath(path.expanduser()) for path in written if path is not None}
    for path in _named(paths, lines):
        for each in _files_in(path, found.passed_over) if os.path.isdir(path) else [path]:  # noqa: PTH112
            real = os.path.realpath(each)
            if real not in seen:
                seen.add(real)
                found.files.append(_looked_at(each))
    return found


def _named(paths: Sequence[str], lines: Iterable[str]) -> Iterator[str]:
    for path in paths:
        if path == "-":
            yield from (line.rstrip("\r\n") for line in lines if line.strip())
        else:
            yield path


def _files_in(folder: str, passed_over: Counter[str]) -> Iterator[str]:
    """The logs of a folder and those below it, in the order of their names; nothing that is hidden."""
    for parent, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for name in sorted(names):
            if name.startswith("."):
                continue
            suffix = os.path.splitext(name.lower().removesuffix(_PACKED))[1]  # noqa: PTH122
            if suffix in LOG_SUFFIXES:
                yield os.path.join(parent, name)  # noqa: PTH118 - a million paths, as they were typed
            else:
                passed_over[suffix or "no suffix"] += 1


def _looked_at(path: str) -> LogFile:
    try:
        status = os.stat(path)  # noqa: PTH116
    except OSError:
        return LogFile(path)
    return LogFile(path, status.st_size, status.st_mtime_ns)
