"""How much memory a DataFlash log takes, and that taking its positions some at a time changes nothing."""

from __future__ import annotations

import gzip
import io
import tracemalloc

import numpy as np
import pytest

from flight_replay.logs.byte_source import OpenLog
from flight_replay.logs.dataflash import row_slices
from flight_replay.logs.read_log import read_open_log
from flight_replay.logs.recording import Recording
from flight_replay.logs.track import COLUMNS
from tests.helpers.dataflash_writer import DataflashWriter
from tests.helpers.paths import DATAFLASH

TRACK_BYTES = 80  # what the columns of a track take for a fix
MOST_BESIDE_BYTES = 36  # 8 million fixes may take 290 MB besides


def read(data: bytes) -> Recording:
    """What a log holds."""
    return read_open_log(OpenLog("flight.bin", io.BytesIO(data)))


def positions_alone(fixes: int) -> bytes:
    """A log of records of POS, 10 Hz."""
    log = DataflashWriter()
    begun = len(log.data)
    log.add("POS", Lat=47.4, Lng=8.5, Alt=410.0, RelHomeAlt=10.0)
    record = np.frombuffer(bytes(log.data[begun:]), np.uint8)
    rows = np.tile(record, (fixes, 1))
    rows[:, 3:11] = (np.arange(fixes, dtype="<u8")[:, None] * 100_000).view(np.uint8)
    return bytes(log.data[:begun]) + rows.tobytes()


def test_positions_alone_take_little_more_than_their_track() -> None:
    """Memory grows by the track's columns and less than half of that at most."""
    peaks = []
    for fixes in (100_000, 300_000):
        data = positions_alone(fixes)
        tracemalloc.start()
        assert len(read(data).track) == fixes
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert (peaks[1] - peaks[0]) / 200_000 < TRACK_BYTES + MOST_BESIDE_BYTES


@pytest.mark.parametrize("at_once", [1, 7, 64])
def test_a_log_is_read_alike_in_pieces_of_any_length(at_once: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A real flight, and again from within it, as of two logs joined."""
    data = gzip.decompress((DATAFLASH / "square.bin.gz").read_bytes())
    whole = read(data + data[len(data) // 3 :])
    monkeypatch.setattr(row_slices, "_ROWS_AT_ONCE", at_once)
    pieces = read(data + data[len(data) // 3 :])
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(pieces.track, name), getattr(whole.track, name), name)
    assert pieces.notes == whole.notes
