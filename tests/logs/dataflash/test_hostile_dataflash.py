"""DataFlash logs made to take long or much memory: 40 MB of each are read, or refused, in seconds."""

from __future__ import annotations

import struct
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from time import process_time

import numpy as np
import pytest

from flight_replay.exceptions import LogError
from flight_replay.logs.flights import find_flights
from flight_replay.logs.read_log import read_log
from tests.helpers.dataflash_writer import DataflashWriter, flight, fmt
from tests.helpers.track_files import read_bytes

SIZE = 40_000_000
LIMIT = 20.0
"""Times as long as an ordinary log of 40 MB: the worst takes 14, 5 s where that takes 0.37 s."""


def filled(log: bytes, piece: bytes) -> bytes:
    """A log, and then a piece again and again."""
    return log + piece * (SIZE // len(piece))


def every_header_jumps() -> bytes:
    """Nothing but headers, each of which may be a record that ends two headers on."""
    log = DataflashWriter(late=True)
    return filled(bytes(log.data) + fmt(0xA3, 4, "EV", "B", "Id"), b"\xa3\x95")


def formats_that_change_all_the_time() -> bytes:
    """Two definitions of one type in turns, and a record of each."""
    first, second = fmt(181, 4, "EV", "B", "Id"), fmt(181, 5, "EV", "BB", "Id,No")
    return filled(
        bytes(DataflashWriter().data), first + b"\xa3\x95\xb5\x0a" + second + b"\xa3\x95\xb5\x0a\x0a"
    )


def one_format_again_and_again() -> bytes:
    """The same definition, which changes nothing."""
    return filled(bytes(flight().data), fmt(181, 12, "EV", "QB", "TimeUS,Id"))


def logs_that_begin_all_the_time() -> bytes:
    """FMT of FMT itself, with a position behind it."""
    position = bytes(DataflashWriter().fix(10.0).data[-31:])
    return filled(
        bytes(DataflashWriter().data), fmt(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format") + position
    )


def formats_that_lie_about_their_length() -> bytes:
    """Records that are longer than their format says."""
    log = DataflashWriter()
    log.data += fmt(44, 20, "XKF1", "Qfff", "TimeUS,VN,VE,VD")
    return filled(bytes(log.data), b"\xa3\x95\x2c" + bytes(50))


def events_without_positions() -> bytes:
    """Ten million armings and disarmings."""
    log = DataflashWriter(late=True)
    return filled(bytes(log.data) + fmt(13, 4, "EV", "B", "Id"), b"\xa3\x95\x0d\x0a\xa3\x95\x0d\x0b")


def armings_between_positions() -> bytes:
    """Two million flights of one position."""
    log = DataflashWriter(late=True)
    begin = bytes(log.data) + fmt(13, 4, "EV", "B", "Id") + fmt(72, 15, "POS", "IIff", "TimeMS,Lat,Lng,Alt")
    return filled(begin[:-89] + fmt(72, 19, "POS", "ILLf", "TimeMS,Lat,Lng,Alt"), _one_fix())


def _one_fix() -> bytes:
    return (
        b"\xa3\x95\x0d\x0a\xa3\x95\x48"
        + struct.pack("<Iiif", 1, 474 << 20, 85 << 20, 400.0)
        + b"\xa3\x95\x0d\x0b"
    )


def times_at_random() -> bytes:
    """Positions whose times have no order."""
    log, n = DataflashWriter(), SIZE // 31
    time_us = np.random.default_rng(1).integers(0, 10**10, n).astype("<u8")
    row = bytes(log.fix(10.0).data[-31:])
    rows = np.tile(np.frombuffer(row, np.uint8), (n, 1))
    rows[:, 3:11] = time_us[:, None].view(np.uint8)
    return bytes(DataflashWriter().data) + rows.tobytes()


def places_at_random() -> bytes:
    """Positions all over the earth, ten a second."""
    log, n = DataflashWriter(), SIZE // 31
    chance = np.random.default_rng(1)
    row = bytes(log.fix(10.0).data[-31:])
    rows = np.tile(np.frombuffer(row, np.uint8), (n, 1))
    rows[:, 3:11] = (np.arange(n, dtype="<u8") * 100_000)[:, None].view(np.uint8)
    rows[:, 11:19] = chance.integers(-(8 * 10**8), 8 * 10**8, (n, 2)).astype("<i4").view(np.uint8)
    return bytes(DataflashWriter().data) + rows.tobytes()


def values_at_random() -> bytes:
    """Records of all kinds with nothing but noise in them."""
    log = flight(fixes=2)
    kinds = np.array([72, 90, 70, 44, 47, 186, 181, 71, 32, 59], np.uint8)
    lengths = {kind: log.length(name) for name, (kind, _, _) in log.formats.items()}
    chance = np.random.default_rng(1)
    noise = chance.integers(0, 256, SIZE, np.uint8)
    at = 0
    while at + 100 < SIZE:
        kind = int(kinds[chance.integers(len(kinds))])
        noise[at : at + 3] = (0xA3, 0x95, kind)
        at += lengths[kind]
    return bytes(log.data) + noise[:at].tobytes()


def text_without_end() -> bytes:
    """Text without any end of a line."""
    return filled(flight().text, b"POS, 1, 2, 3, ")


HOSTILE = (
    every_header_jumps,
    formats_that_change_all_the_time,
    one_format_again_and_again,
    logs_that_begin_all_the_time,
    formats_that_lie_about_their_length,
    events_without_positions,
    armings_between_positions,
    times_at_random,
    places_at_random,
    values_at_random,
    text_without_end,
)


def test_a_log_of_positions_alone_takes_little_memory_besides_its_track() -> None:
    """A track has 77 bytes a fix."""
    n = 300_000
    log = DataflashWriter()
    rows = np.tile(np.frombuffer(bytes(log.fix(10.0).data[-31:]), np.uint8), (n, 1))
    rows[:, 3:11] = (np.arange(n, dtype="<u8") * 40_000)[:, None].view(np.uint8)
    data = bytes(DataflashWriter().data) + rows.tobytes()
    tracemalloc.start()
    assert len(read_bytes(data).track) == n
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < n * 130 + (15 << 20)


@pytest.fixture(scope="module")
def ordinary_s(tmp_path_factory: pytest.TempPathFactory) -> float:
    """How long 40 MB of a flight take on this machine."""
    path = tmp_path_factory.mktemp("logs") / "ordinary.bin"
    path.write_bytes(bytes(flight(fixes=40_000).data) * 3)
    begin = process_time()
    find_flights(read_log(path).track)
    return (process_time() - begin) * SIZE / path.stat().st_size


@pytest.mark.slow
@pytest.mark.parametrize("made", HOSTILE)
def test_logs_made_to_take_long_do_not(made: Callable[[], bytes], tmp_path: Path, ordinary_s: float) -> None:
    """Each is read, or refused in one line, in the time of a few ordinary logs."""
    path = tmp_path / "hostile.bin"
    path.write_bytes(made())
    begin = process_time()
    try:
        recording = read_log(path)
        find_flights(recording.track)
    except LogError as error:
        assert "\n" not in str(error)
    assert process_time() - begin < LIMIT * max(ordinary_s, 0.4)
