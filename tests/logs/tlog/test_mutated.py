"""Damaged logs: no exception but the reader's own, no hang, and no position that was not recorded."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest

from flight_replay.exceptions import LogError
from flight_replay.logs.byte_source import OpenLog
from flight_replay.logs.read_log import read_log
from flight_replay.logs.tlog.scan import scan
from flight_replay.logs.track import Track
from tests.helpers import slow_reader
from tests.helpers.log_writer import LogWriter, frame
from tests.helpers.mutations import MUTATIONS, mutated
from tests.helpers.paths import ARDUCOPTER, OTHER_LOGS, SAMPLE

Place = tuple[int, int, int]
SLICE_LENGTH = 2_000  # bytes of a real log that are mutated at a time
FIXES = 10  # of a made log


def originals() -> list[bytes]:
    """Small logs of every kind, and slices of real ones where they are at hand."""
    made = []
    for version, stamp_us in ((1, 1_700_000_000_000_000), (2, 1_700_000_000_000_000), (2, None)):
        log = LogWriter(version=version, stamp_us=stamp_us).heartbeat(True).empty(9_000)
        for fix in range(FIXES):
            log.position(
                10_000 + fix * 250, 47.4 + fix * 1e-5, 8.5 - fix * 1e-5, fix / 2, velocity=(4, -3, 0)
            )
            log.gps(3).heartbeat(fix % 8 != 0)
            log.data += frame(
                253, b"\6Reached command".ljust(51, b"."), version, signed=version == 2 and fix % 3 == 0
            )
        made.append(bytes(log.data))
    for path in [SAMPLE, *ARDUCOPTER.glob("*.tlog"), *sorted(OTHER_LOGS.glob("**/*.[tr]log"))]:
        data = path.read_bytes()
        made += [data[at : at + SLICE_LENGTH] for at in (0, len(data) // 3, len(data) * 2 // 3)]
    return made


def places(data: bytes) -> set[Place]:
    """The positions of a log, empty ones too."""
    return {(each.lat_e7, each.lon_e7, each.alt_mm) for each in slow_reader.positions(data)}


def places_of(track: Track) -> set[Place]:
    """The positions of a track, in the units of the records."""
    columns = (track.lat_deg * 1e7, track.lon_deg * 1e7, track.alt_m * 1e3)
    return set(zip(*(np.rint(column).astype(int).tolist() for column in columns), strict=True))


def assert_as_slow(data: bytes, block_length: int) -> None:
    """Hold the records against the plain reader's."""
    records, _ = scan(OpenLog("mutated", io.BytesIO(data)), None, block_length)
    positions = records.positions.select(~records.positions.is_empty)
    slow = [each for each in slow_reader.positions(data) if not each.is_empty]
    assert positions.offset.tolist() == [each.offset for each in slow]


def mutate_and_read(first: int, last: int, path: Path, compared: int = 1) -> tuple[int, int]:
    """Read mutated logs, by their seeds: how many were usable, how many positions in no original.

    One in ``compared`` is read by the plain reader, too.
    """
    logs = originals()
    known = set().union(*(places(data) for data in logs))
    usable = strangers = 0
    for seed in range(first, last):
        chance = np.random.default_rng(seed)
        data = mutated(logs, chance, MUTATIONS)
        if seed % compared == 0:
            assert_as_slow(data, int(chance.choice([300, 1_000, 1 << 20])))
        path.write_bytes(data)
        try:
            log = read_log(path)
        except LogError as error:
            assert str(path) in str(error)
        else:
            usable += 1
            assert log.vehicle is not None
            assert len(log.track) == log.vehicle.fixes > 0
            assert (np.diff(log.track.time_s) >= 0).all()
            assert np.isfinite(log.track.north_east_m()).all()
            strangers += len(places_of(log.track) - known)
    return usable, strangers


def test_damaged_logs_give_recorded_positions_or_one_clear_error(tmp_path: Path) -> None:
    """Hundreds of mutated logs raise nothing else, agree with the plain reader, and invent nothing.

    A damaged frame passes its CRC once in 65,536: of these few logs, none is expected to.
    """
    usable, strangers = mutate_and_read(0, 300, tmp_path / "mutated.tlog")
    assert usable > 150
    assert strangers == 0


@pytest.mark.slow
@pytest.mark.parametrize("first", range(1_000, 21_000, 2_000))
def test_twenty_thousand_damaged_logs_give_recorded_positions_or_one_clear_error(
    first: int, tmp_path: Path
) -> None:
    """As above, in ten parts. Each mutation damages about ten frames, of which one in ten is a position.

    So of the 4,000 mutations of a part some 4,000 / 65,536, less than a tenth of a position, are
    expected to pass their CRC by chance; more than two would mean that something is wrong.
    """
    usable, strangers = mutate_and_read(first, first + 2_000, tmp_path / "mutated.tlog", 4)
    assert usable > 1_000
    assert strangers <= 2
