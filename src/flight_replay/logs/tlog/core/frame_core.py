"""Calls the searches in C (``_frame_core.c``), where the wheel has them; callers use numpy elsewhere.

Everything that is handed to C is checked and made here: it does not look at bytes but those of the arrays.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Bytes, Flags, Indices
from flight_replay.logs.tlog.crc import OF_FOURS
from flight_replay.logs.tlog.message_table import EXTRAS, MAVLINK1_SHAPES

_HEADER_LENGTH = 10  # bytes of the longest header
_MOST_IDS = 3  # messages that are searched at a time
_ROOM = (1 + _MOST_IDS) << 21  # places: as many as a slice of a log has, for each of the messages


class FrameCore:
    """The compiled searches."""

    def __init__(self, library: Path) -> None:
        """Load a library.

        Raises:
            OSError, AttributeError: It is none, or another.
        """
        functions = ctypes.CDLL(str(library))
        self._find_headers = functions.find_headers
        self._find_enclosures = functions.find_enclosures
        self._check_frames = functions.check_frames
        self._lock = Lock()
        self._found = np.empty(_ROOM, np.int64)
        self._shapes, self._crc_tables = _address(MAVLINK1_SHAPES), (_address(EXTRAS), _address(OF_FOURS))
        pointer, number = ctypes.c_void_p, ctypes.c_int64
        self._find_headers.argtypes = [pointer, number, *[pointer] * 5]
        self._find_headers.restype = None
        self._find_enclosures.argtypes = [pointer, pointer, number, number, *[pointer] * 5]
        self._find_enclosures.restype = number
        self._check_frames.argtypes = [pointer, number, pointer, number, *[pointer] * 3]
        self._check_frames.restype = None

    def headers(
        self, data: Bytes, part: tuple[int, int], ids: Sequence[int], by_shape: Bytes, by_id: Bytes
    ) -> list[Indices]:
        """Where frames of some messages may begin: an ascending array (n,) for each.

        Args:
            data: Bytes.
            part: The first place where frames may begin, and the first behind these: ten bytes follow.
            ids: One to three messages, which are numbered from 1.
            by_shape: The number of the message by MAVLink 1 payload length + 256 * id, 0 for none (65536,).
            by_id: The number of the message by id (256,).
        """
        start, stop = part
        length = stop - start
        _require(0 <= start <= stop <= len(data) - _HEADER_LENGTH and 1 <= len(ids) <= _MOST_IDS)
        three = np.array([*ids, *[ids[0]] * (_MOST_IDS - len(ids))], np.uint8)
        counts = np.zeros(1 + len(ids), np.int64)
        tables = _address(three), _address(by_shape), _address(by_id)
        with self._room(1 + len(ids), length) as starts:
            self._find_headers(_address(data) + start, length, *tables, _address(starts), _address(counts))
            found = (its[:count] for its, count in zip(starts[1:], counts[1:].tolist(), strict=True))
            return [(its + start).astype(np.intp, copy=False) for its in found]

    def enclosures(
        self, data: Bytes, places: Indices, shortest1: Bytes, shortest2: Bytes
    ) -> tuple[Indices, Indices]:
        """Pairs (n,) of where a frame may begin and of the place which it may reach.

        Args:
            data: Bytes.
            places: The places.
            shortest1: Shortest payload of MAVLink 1 that may reach, by place in the bytes up to there.
            shortest2: That of MAVLink 2.
        """
        reach = len(shortest1)
        its = np.ascontiguousarray(places, np.int64)
        _require(not len(its) or (its.min() >= reach - 1 and its.max() <= len(data) - _HEADER_LENGTH))
        tables = _address(shortest1), _address(shortest2), self._shapes
        with self._room(2, len(its) * reach) as (starts, around):
            count = self._find_enclosures(
                _address(data), _address(its), len(its), reach, *tables, _address(starts), _address(around)
            )
            return starts[:count].astype(np.intp), around[:count].astype(np.intp)

    def are_valid(self, data: Bytes, starts: Indices) -> Flags:
        """Whether the CRCs of frames (n,) are valid, and all of each in the data."""
        its = np.ascontiguousarray(starts, np.int64)
        _require(not len(its) or (its.min() >= 0 and its.max() < len(data)))
        valid = np.empty(len(its), np.bool_)
        tables = self._crc_tables
        self._check_frames(_address(data), len(data), _address(its), len(its), *tables, _address(valid))
        return valid

    @contextmanager
    def _room(self, rows: int, length: int) -> Iterator[NDArray[np.int64]]:
        """Room for what is found, shape (rows, length), most of which is never touched."""
        with self._lock:
            size = rows * length
            room = self._found if size <= len(self._found) else np.empty(size, np.int64)
            yield room[:size].reshape(rows, length)


def _require(is_right: bool | np.bool_) -> None:
    if not is_right:
        raise IndexError("outside of the bytes")


def _address(array: NDArray[np.generic]) -> int:
    """Where the elements of an array are, side by side."""
    if not array.flags.c_contiguous:
        raise ValueError("not side by side")
    return array.ctypes.data


def load(folder: Path) -> FrameCore | None:
    """The searches that were compiled for this Python into a folder; None where there are none."""
    if sys.byteorder != "little":  # which the C takes for granted in words of flags
        return None
    for suffix in EXTENSION_SUFFIXES:
        try:
            return FrameCore(folder / f"_frame_core{suffix}")
        except (OSError, AttributeError):
            continue
    return None


CORE = load(Path(__file__).parent)
"""None in an editable install, and where there was no compiler."""
