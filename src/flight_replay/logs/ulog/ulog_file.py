"""The topics of a ULog (docs.px4.io, "ULog File Format") as columns, read by pyulog in bounded time."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flight_replay.exceptions import LogError
from flight_replay.geometry.arrays import Flags, Floats
from flight_replay.logs.byte_source import OpenLog, Progress, contents

if TYPE_CHECKING:
    from pyulog.core import ULog

_MOST_BUFFERED = 512 << 20
"""pyulog needs a file to move in: what comes through a pipe or out of gzip is kept in memory."""
_MOST_FIELDS = 4096
"""No topic of PX4 has a tenth of them, but formats of formats can say more than any memory holds."""
_READS_A_BYTE = 0.1
"""pyulog reads twice a message, and messages are longer than 20 bytes in the mean."""
_READS_AT_LEAST = 200_000
"""pyulog searches damaged bytes one by one, a third of a second for so many."""
_BUFFER_LENGTH = 1 << 20
_LONGEST_S = 10 * 86_400.0
_TIMES_PER_S = 1e6
_FIX_3D = 3
_MOSTLY = 0.8
"""A receiver with less than this part of the fixes of another was out of order or late."""


@dataclass(frozen=True, slots=True, eq=False)
class Topic:
    """The samples of one topic in the order of time: seconds since boot (n,) and its fields (n,)."""

    time_s: Floats
    fields: Mapping[str, Floats]

    def __len__(self) -> int:
        return len(self.time_s)

    def __contains__(self, name: str) -> bool:
        return name in self.fields

    def get(self, *names: str) -> Floats:
        """The first field of these names that there is, else values that are not a number."""
        return next((self.fields[name] for name in names if name in self), np.full(len(self), np.nan))

    def select(self, keep: Flags) -> Topic:
        """The samples that a mask (n,) picks."""
        return Topic(self.time_s[keep], {name: column[keep] for name, column in self.fields.items()})


@dataclass(frozen=True, slots=True, eq=False)
class UlogTopics:
    """What was read of a ULog: topics by name, its info messages, its bytes, and what went wrong."""

    topics: Mapping[str, Topic]
    info: Mapping[str, object]
    bytes: int
    is_damaged: bool
    dropouts_s: float


def read_topics(log: OpenLog, names: tuple[str, ...], progress: Progress | None) -> UlogTopics:
    """Read some topics, of each the first instance, and of receivers the first that had most of the fixes.

    Raises:
        LogError: Its header or its formats cannot be read.
    """
    if log.file is not None:
        length = log.size
        files = _from_disk(log.file, length, progress)
    else:
        data = contents(log, _MOST_BUFFERED, progress)
        length = len(data)
        files = lambda: _PatientFile(io.BytesIO(data), length)  # noqa: E731
    ulog, was_stopped = _parsed(files, names, log.name)
    topics = {name: topic for name in names if (topic := _topic(ulog, name)) is not None}
    dropouts_s = sum(dropout.duration for dropout in ulog.dropouts) / 1e3
    return UlogTopics(
        topics, dict(ulog.msg_info_dict), length, bool(ulog.file_corruption) or was_stopped, dropouts_s
    )


def _parsed(files: Callable[[], _PatientFile], names: tuple[str, ...], name: str) -> tuple[ULog, bool]:
    """What pyulog reads, and whether it was stopped while it searched.

    It knows all formats before the first sample, so that those which unfold without end are found.
    """
    from pyulog import core
    from pyulog.exceptions import ULogException

    vars(core)["print"] = _say_nothing  # It prints what goes wrong, which would stand amid our output.
    try:
        header = core.ULog(files(), [], parse_header_only=True)
        if max(_field_counts(header.message_formats).values(), default=0) > _MOST_FIELDS:
            raise LogError(f"{name} has a damaged list of formats; name another log")
        file = files()
        return core.ULog(file, list(names)), file.is_exhausted
    except ULogException as error:
        raise LogError(f"{name} is a ULog that cannot be read ({error}); name another log") from error
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise LogError(f"{name} is a damaged ULog ({type(error).__name__}); name another log") from error


def _say_nothing(*_: object, **__: object) -> None:
    """In place of ``print``."""


def _field_counts(formats: Mapping[str, Any]) -> dict[str, int]:
    """How many values a sample of each format has, which may hold others; a circle counts as too many."""
    counts: dict[str, int] = {}

    def count(name: str, around: tuple[str, ...]) -> int:
        if name not in formats:
            return 1
        if name in around or len(around) > 20:
            return _MOST_FIELDS + 1
        if name not in counts:
            fields = formats[name].fields
            inner = (max(size, 1) * count(kind, (*around, name)) for kind, size, _ in fields)
            counts[name] = min(sum(inner), _MOST_FIELDS + 1)
        return counts[name]

    return {name: count(name, ()) for name in formats}


def _topic(ulog: ULog, name: str) -> Topic | None:
    """The samples of a topic's first instance that was not idle, in the order of time."""
    found = [each for each in ulog.data_list if each.name == name and "timestamp" in each.data]
    if not found:
        return None
    enough = _MOSTLY * max(map(_usable, found))
    found = [each for each in found if _usable(each) >= enough]
    data = min(found, key=lambda each: (each.multi_id, -len(each.data["timestamp"]))).data
    time_s = data["timestamp"] / _TIMES_PER_S
    # Damage can say any time.
    near = np.abs(time_s - np.median(time_s)) <= _LONGEST_S
    order = np.flatnonzero(near)[np.argsort(time_s[near], kind="stable")]
    with np.errstate(invalid="ignore"):  # Damage can be a signalling NaN.
        fields = {field: np.asarray(column, float)[order] for field, column in data.items()}
    return Topic(time_s[order], fields)


def _usable(data: Any) -> int:
    """How many samples of a receiver have a 3D fix; 0 for other topics, whose instances are all as good."""
    return int(np.count_nonzero(data.data["fix_type"] >= _FIX_3D)) if "fix_type" in data.data else 0


def _from_disk(path: Path, size: int, progress: Progress | None) -> Callable[[], _PatientFile]:
    def opened() -> _PatientFile:
        return _PatientFile(_CountedFile(path, size, progress), size)

    return opened


class _CountedFile(io.FileIO):
    """A file that tells how far it was read."""

    def __init__(self, path: Path, size: int, progress: Progress | None) -> None:
        super().__init__(path)
        self._size, self._progress = size, progress

    def readinto(self, buffer: Any, /) -> int | None:
        got = super().readinto(buffer)
        if self._progress and got:
            self._progress(min(self.tell(), self._size), self._size)
        return got


class _PatientFile(io.BufferedReader):
    """A file that is at its end once it was read more often than an intact one has messages.

    In damaged ones pyulog goes byte by byte, or back again and again where a message claims to be longer
    than the file.
    """

    def __init__(self, raw: io.FileIO | io.BytesIO, length: int) -> None:
        super().__init__(raw, _BUFFER_LENGTH)
        self._reads_left = _READS_AT_LEAST + int(length * _READS_A_BYTE)

    @property
    def is_exhausted(self) -> bool:
        """Whether it ended before its bytes did."""
        return self._reads_left < 0

    def read(self, size: int | None = -1, /) -> bytes:
        """Read; nothing, once it is exhausted."""
        self._reads_left -= 1
        return b"" if self._reads_left < 0 else super().read(size)
