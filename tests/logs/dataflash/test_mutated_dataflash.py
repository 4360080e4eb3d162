"""Damaged DataFlash logs: no exception but the reader's own, no hang, and no position but recorded ones.

Records have no checksum, so two kinds of damage cannot be seen. Changed bits in a record are one. The
other is a torn record where the log goes on with just as many bytes of another one as are missing, so
that a header follows where one must: as records have about 45 bytes, one cut in 45 makes such a one of
the record that it goes through. Of these made logs positions are a tenth of the bytes, so one cut in 450
is expected to make a position of two records (one in 6,000 of a real log of 4.6, of which they are
0.7 %); where it shows by its time, or as a jump, it is left out. A shuffled log has about sixty cuts.
"""

from __future__ import annotations

import gzip
import io
import struct
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from flight_replay.exceptions import LogError
from flight_replay.logs.byte_source import OpenLog
from flight_replay.logs.dataflash.collected import MESSAGES
from flight_replay.logs.dataflash.record_stream import RecordStream
from flight_replay.logs.flights import find_flights
from flight_replay.logs.read_log import read_log
from tests.helpers import slow_dataflash
from tests.helpers.dataflash_writer import COPTER_33, DataflashWriter, flight
from tests.helpers.mutations import MOVES, MUTATIONS, mutated
from tests.helpers.paths import DATAFLASH

Place = tuple[float, float, float]
SLICE_LENGTH = 8_000  # bytes of a real log that are mutated at a time


@cache
def originals() -> tuple[bytes, ...]:
    """Small logs of several firmwares, and slices of a real one behind its formats."""
    old = DataflashWriter(dict(COPTER_33)).add("EV", Id=10)
    for number in range(60):
        old.add("ATT", TimeMS=number * 200, Yaw=number * 3.0).add("EKF1", TimeMS=number * 200, VN=number / 7)
        place = {"Lat": 47.4, "Lng": 8.5 + number * 1e-5, "RelAlt": number / 10}
        old.add("GPS", Status=3, TimeMS=number * 200, Week=1800, T=number * 200, **place)
    made = [bytes(flight(fixes=30).data), bytes(flight(50.0, 30, late=True).data), bytes(old.data)]
    real = gzip.decompress((DATAFLASH / "square.bin.gz").read_bytes())
    kept = [record for _, name, record in _all_records(real[:80_000]) if name == "FMT" and _is_read(record)]
    for at in (100_000, 2_000_000, len(real) - SLICE_LENGTH):
        made.append(b"".join(kept) + real[at : at + SLICE_LENGTH])
    return tuple(made)


def _all_records(data: bytes) -> list[tuple[int, str, bytes]]:
    """The FMT records at the beginning of a log."""
    found = []
    for at in range(0, len(data), slow_dataflash.FMT_LENGTH):
        if not data.startswith(b"\xa3\x95\x80", at):
            break
        found.append((at, "FMT", data[at : at + slow_dataflash.FMT_LENGTH]))
    return found


def _is_read(fmt: bytes) -> bool:
    return fmt[5:9].rstrip(b"\0").decode() in (*MESSAGES, "FMT")


def places(data: bytes) -> set[Place]:
    """Time, latitude and longitude of all positions of a log, as the plain reader finds them."""
    found = set()
    for _, name, record in slow_dataflash.records(data):
        if name == "POS" and len(record) == 31:
            time_us, lat_e7, lon_e7 = struct.unpack_from("<Qii", record, 3)
            found.add((time_us / 1e6, lat_e7 / 1e7, lon_e7 / 1e7))
        elif name == "GPS" and len(record) == 45:
            lat_e7, lon_e7 = struct.unpack_from("<ii", record, 13)
            found.add((struct.unpack_from("<I", record, 41)[0] / 1e3, lat_e7 / 1e7, lon_e7 / 1e7))
        elif name == "GPS":
            lat_e7, lon_e7 = struct.unpack_from("<ii", record, 21)
            found.add((struct.unpack_from("<Q", record, 3)[0] / 1e6, lat_e7 / 1e7, lon_e7 / 1e7))
    return found


def assert_as_slow(data: bytes, block_length: int) -> None:
    """Hold the records against the plain reader's."""
    stream = RecordStream(OpenLog("mutated", io.BytesIO(data)), MESSAGES, None, block_length)
    found = sorted((int(at), rows.name) for block in stream.blocks() for rows in block for at in rows.offset)
    expected = [(at, name) for at, name, _ in slow_dataflash.records(data) if name in MESSAGES]
    assert found == expected


def mutate_and_read(first: int, last: int, path: Path, compared: int = 1) -> tuple[int, int, int]:
    """Read mutated logs, by their seeds: how many were usable.

    Of those whose bytes were only moved, also how many fixes they gave, and how many in no original.
    Two of twice ``compared`` are read by the plain reader, too.
    """
    known = {place[1:] for data in originals() for place in places(data)}
    usable = fixes = strangers = 0
    for seed in range(first, last):
        chance = np.random.default_rng(seed)
        mutations = MUTATIONS if seed % 2 else MOVES
        data = mutated(list(originals()), chance, mutations)
        if seed % (2 * compared) < 2:
            assert_as_slow(data, int(chance.choice([300, 1_000, 1 << 20])))
        path.write_bytes(data)
        try:
            log = read_log(path)
        except LogError as error:
            assert str(path) in str(error)
            assert "\n" not in str(error)
            continue
        usable += 1
        track = log.track
        assert (np.diff(track.time_s) >= 0).all()
        assert np.isfinite(track.north_east_m()).all()
        assert np.isfinite(track.alt_m).all()
        find_flights(track)
        if mutations is MOVES:
            fixes += len(track)
            found = zip(track.lat_deg.tolist(), track.lon_deg.tolist(), strict=True)
            strangers += sum(place not in known for place in found)
    return usable, fixes, strangers


def test_damaged_logs_give_recorded_positions_or_one_clear_error(tmp_path: Path) -> None:
    """Hundreds of mutated logs raise nothing else and agree with the plain reader.

    Half of them have been cut only: 150 logs with two mutations, of which one in four shuffles, have
    some 4,500 cuts, so that about ten positions of two records are expected.
    """
    usable, fixes, strangers = mutate_and_read(0, 300, tmp_path / "mutated.bin")
    assert usable > 100
    assert fixes > 1_000
    assert strangers <= 20


def test_damaged_logs_as_text_give_fixes_or_one_clear_error(tmp_path: Path) -> None:
    """Hundreds of them raise nothing else."""
    path, usable = tmp_path / "mutated.log", 0
    for seed in range(150):
        chance = np.random.default_rng(seed)
        text = flight(fixes=30).text
        for _ in range(chance.integers(1, 4)):
            if text:
                text = MUTATIONS[chance.integers(len(MUTATIONS))](text, chance, [text])
        path.write_bytes(text)
        try:
            log = read_log(path)
        except LogError as error:
            assert str(path) in str(error)
            continue
        usable += 1
        assert np.isfinite(log.track.alt_m).all()
        assert (np.diff(log.track.time_s) >= 0).all()
    assert usable > 50


@pytest.mark.slow
@pytest.mark.parametrize("first", range(1_000, 21_000, 2_000))
def test_twenty_thousand_damaged_logs_give_recorded_positions_or_one_clear_error(
    first: int, tmp_path: Path
) -> None:
    """As above, in ten parts: of each, about seventy positions of two records are expected."""
    usable, fixes, strangers = mutate_and_read(first, first + 2_000, tmp_path / "mutated.bin", 4)
    assert usable > 600
    assert fixes > 6_000
    assert strangers <= 110
