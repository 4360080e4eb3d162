"""The fast reader finds what a walk over every byte finds."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from pymavlink.dialects.v10 import all as mavlink1
from pymavlink.dialects.v20 import all as mavlink2

from flight_replay.logs import byte_source
from flight_replay.logs.tlog import blocks, frame_search, message_table
from flight_replay.logs.tlog.byte_rows import true_indices
from flight_replay.logs.tlog.columns import MessageColumns, Records
from flight_replay.logs.tlog.crc import are_crcs_valid, is_crc_valid
from flight_replay.logs.tlog.scan import scan
from tests.helpers import slow_reader
from tests.helpers.log_writer import (
    ENCAPSULATED_DATA,
    FILE_TRANSFER,
    GLOBAL_POSITION_INT,
    GPS_RAW_INT,
    HEARTBEAT,
    START_US,
    STATUSTEXT,
    TUNNEL,
    frame,
    gps_payload,
    heartbeat_payload,
    position_payload,
)
from tests.helpers.paths import ARDUCOPTER, OTHER_LOGS

WHOLE_LOGS = [*ARDUCOPTER.glob("*.tlog"), *sorted(OTHER_LOGS.glob("**/*.[tr]log"))]
POSITION = position_payload(123_456, 47.4, 8.5)


def read(data: bytes, block_length: int, path: Path | None = None) -> Records:
    """The records of bytes read in blocks of that length, out of a file where a path is given."""
    if path is None:
        return scan(byte_source.OpenLog("made", _Bytes(data)), None, block_length)[0]
    path.write_bytes(data)
    with byte_source.open_log(path) as opened:
        return scan(opened, None, block_length)[0]


class _Bytes:
    """A stream that hands out a few bytes at a time."""

    def __init__(self, data: bytes) -> None:
        self._data = data

    def readinto(self, buffer: memoryview, /) -> int:
        given, self._data = self._data[:700], self._data[700:]
        fits = min(len(given), len(buffer))
        buffer[:fits], self._data = given[:fits], given[fits:] + self._data
        return fits


def last_word(columns: MessageColumns, said: NDArray[np.bool_], each: slow_reader.Position) -> bool | None:
    """What the last record of a position's vehicle before it says."""
    before = np.flatnonzero((columns.vehicle == each.key) & (columns.offset < each.offset))
    return bool(said[before[-1]]) if len(before) else None


def assert_equal_to_slow(records: Records, data: bytes) -> None:
    """Hold fast records against a walk over every byte, fix by fix."""
    slow = slow_reader.positions(data)
    expected = [each for each in slow if not each.is_empty]
    fast = records.positions.select(~records.positions.is_empty)
    assert fast.offset.tolist() == [each.offset for each in expected]
    rows = zip(*(getattr(fast, name).tolist() for name in _COLUMNS), strict=True)
    assert list(rows) == [
        (each.key, each.time_ms, each.lat_e7, each.lon_e7, each.amsl_mm, each.alt_mm, *each.velocity_cm_s)
        for each in expected
    ]
    assert sum(records.empty.values()) == len(slow) - len(expected)
    assert {each.offset for each in slow} >= set(records.positions.offset.tolist())
    beats = records.heartbeats.select(records.heartbeats.autopilot != 8)
    for each in expected[:: max(len(expected) // 200, 1)]:
        assert last_word(beats, beats.armed, each) == each.armed
        assert last_word(records.gps, records.gps.has_3d_fix, each) == each.is_3d


_COLUMNS = [
    "vehicle",
    "time_ms",
    "lat_e7",
    "lon_e7",
    "amsl_mm",
    "alt_mm",
    "north_cm_s",
    "east_cm_s",
    "down_cm_s",
]


@pytest.mark.parametrize("path", WHOLE_LOGS, ids=lambda path: path.name)
def test_real_logs_are_read_as_by_a_walk_over_every_byte(path: Path) -> None:
    """On real logs the fast reader and the plain one agree on every fix, read whole or in small blocks."""
    data = path.read_bytes()
    with byte_source.open_log(path) as opened:
        assert_equal_to_slow(scan(opened)[0], data)
    assert_equal_to_slow(read(data, 50_000), data)


positions = st.builds(
    position_payload,
    st.integers(0, 2**32 - 1),
    st.floats(-90, 90),
    st.floats(-180, 180),
    st.floats(-400, 5000),
    st.tuples(*[st.floats(-300, 300)] * 3),
    st.sampled_from([0.0, 1.0, 300.0]),
)
wanted = st.one_of(
    st.tuples(st.just(GLOBAL_POSITION_INT), positions),
    st.tuples(st.just(GLOBAL_POSITION_INT), st.just(position_payload(5, 0, 0, 0, heading_deg=0))),
    st.tuples(
        st.just(HEARTBEAT),
        st.builds(heartbeat_payload, st.booleans(), st.sampled_from([2, 6]), st.sampled_from([3, 8])),
    ),
    st.tuples(st.just(GPS_RAW_INT), st.builds(gps_payload, st.integers(0, 6), st.just(1))),
)
versions = st.sampled_from([1, 2])


@st.composite
def frames(draw: st.DrawFn) -> bytes:
    message, payload = draw(wanted)
    version = 2 if message > 255 else draw(versions)
    return frame(message, payload, version, draw(st.sampled_from([1, 1, 9])), 1, draw(st.booleans()))


@st.composite
def nests(draw: st.DrawFn) -> bytes:
    """A frame that carries frames, its own CRC right or wrong."""
    inside = b"".join(draw(st.lists(frames(), min_size=1, max_size=5)))
    message, room = draw(st.sampled_from([(ENCAPSULATED_DATA, 253), (TUNNEL, 128), (FILE_TRANSFER, 251)]))
    begin = draw(st.integers(0, 40))
    size = mavlink2.mavlink_map[message].unpacker.size
    payload = (b"\1" * (size - room) + bytes(begin) + inside)[:size].ljust(size, b"\x55")
    whole = bytearray(frame(message, payload, 2 if message > 255 else draw(versions)))
    if draw(st.booleans()):
        whole[-1] ^= 0x10
    return bytes(whole)


@st.composite
def torn(draw: st.DrawFn) -> bytes:
    whole = draw(frames())
    cut = draw(st.integers(1, len(whole)))
    return whole[:cut] if draw(st.booleans()) else whole[-cut:]


stamps = st.integers(START_US, START_US + 10**12).map(lambda value: struct.pack(">Q", value))
junk = st.one_of(
    st.binary(max_size=40),
    st.lists(st.sampled_from([0xFE, 0xFD, 0, 1, 9, 28, 33, 24]), max_size=40).map(bytes),
    st.integers(0, 300).map(lambda size: b"\xfe" * size),
)
pieces = st.one_of(frames(), frames(), st.builds(bytes.__add__, stamps, frames()), nests(), torn(), junk)
logs = st.lists(pieces, max_size=25).map(b"".join)


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    data=logs,
    block_length=st.sampled_from([40, 300, 1000, 1 << 20]),
    slice_length=st.sampled_from([16, 90, 1 << 20]),
)
def test_made_logs_are_read_as_by_a_walk_over_every_byte(
    data: bytes, block_length: int, slice_length: int, tmp_path: Path
) -> None:
    """Mixed, signed, nested, torn and junk-ridden logs give the same fixes, whatever the blocks."""
    assume(not data.startswith(b"\x1f\x8b\x08"))  # which would be read as gzip
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(blocks, "SLICE_LENGTH", slice_length)
        patch.setattr(frame_search, "_PIECE_LENGTH", max(slice_length // 2, 8))
        assert_equal_to_slow(read(data, block_length), data)
        assert_equal_to_slow(read(data, block_length, tmp_path / "made.tlog"), data)


@pytest.mark.parametrize("version", [1, 2])
def test_a_frame_inside_another_frames_payload_is_no_record(version: int) -> None:
    """The outer frame hides the inner one, and gives it back when its own CRC is wrong."""
    inner = frame(GLOBAL_POSITION_INT, POSITION, 1)
    outer = frame(ENCAPSULATED_DATA, (b"\1\1" + inner).ljust(255, b"\7"), version)
    after = frame(GLOBAL_POSITION_INT, POSITION, 2)
    assert read(outer + after, 1000).positions.offset.tolist() == [len(outer)]
    broken = outer[:-1] + bytes([outer[-1] ^ 1])
    assert len(read(broken + after, 1000).positions) == 2


def test_the_hidden_can_hide_nothing() -> None:
    """A right frame that lies in a record hides no frame behind that record."""
    head = bytes([0xFE, 255, 7, 1, 1, ENCAPSULATED_DATA]) + b"\7" * 94
    record = frame(ENCAPSULATED_DATA, bytes(155) + head, 1)
    late = frame(GLOBAL_POSITION_INT, POSITION, 1)
    reaching = (head + record[-2:] + late).ljust(261, b"\0")
    crc = slow_reader.crc(reaching[1:] + bytes([mavlink2.mavlink_map[ENCAPSULATED_DATA].crc_extra]))
    data = record + reaching[102:] + crc.to_bytes(2, "little")
    assert [each.message for each in slow_reader.walk(data)] == [ENCAPSULATED_DATA, GLOBAL_POSITION_INT]
    assert read(data, 1000).positions.offset.tolist() == [len(record)]
    alone = data[len(record) - 102 :]
    assert [each.message for each in slow_reader.walk(alone)] == [ENCAPSULATED_DATA]
    assert not len(read(alone, 1000).positions)


def test_blocks_that_begin_inside_a_frame_are_entered_where_the_walk_comes_out() -> None:
    """A chain of nested frames longer than the look before a block is still read as one walk reads it."""
    inner = frame(GLOBAL_POSITION_INT, POSITION, 1)
    outer = frame(ENCAPSULATED_DATA, (b"\1\1" + inner * 6).ljust(255, b"\7"), 1)
    data = outer * 40 + inner
    for block_length in (100, 257, 1030):
        assert_equal_to_slow(read(data, block_length), data)


def test_thousands_of_positions_side_by_side_are_told_from_nested_ones() -> None:
    """However many frames are looked back from at a time, those in another frame are no records."""
    inner = frame(GLOBAL_POSITION_INT, POSITION, 1)
    outer = frame(ENCAPSULATED_DATA, (b"\1\1" + inner * 6).ljust(255, b"\7"), 1)
    data = inner * 2_100 + outer + inner * 2_100 + outer * 2 + inner
    assert_equal_to_slow(read(data, 1 << 20), data)


@pytest.mark.parametrize("seed", range(12))
def test_of_equal_heartbeats_in_a_row_the_first_and_last_right_ones_are_kept(seed: int) -> None:
    """Damaged and nested ones begin, end and cut runs of the right ones, which are found all the same."""
    chance = np.random.default_rng(seed)
    data = b""
    for _ in range(400):
        status = chance.choice([0, 0, 0, 0, 1, 2], size=2)
        beat = frame(HEARTBEAT, heartbeat_payload(status[0] == 1), 1 + seed % 2, 1 + int(chance.integers(2)))
        match status[1]:
            case 1:
                beat = beat[:-1] + bytes([beat[-1] ^ 1])
            case 2:
                beat = frame(ENCAPSULATED_DATA, (b"\1\1" + beat).ljust(255, b"\7"))
        data += beat
    runs: dict[int, list[list[int]]] = {}
    last: dict[int, bool] = {}
    for each in slow_reader.walk(data):
        if each.message == HEARTBEAT:
            armed, vehicle = each.payload[6] & 128 != 0, each.vehicle[0]
            if last.get(vehicle) != armed:
                runs.setdefault(vehicle, []).append([])
            last[vehicle] = armed
            runs[vehicle][-1].append(each.offset)
    kept = {run[end] for its in runs.values() for run in its for end in (0, -1)}
    assert read(data, 1 << 20).heartbeats.offset.tolist() == sorted(kept)


@pytest.mark.parametrize("share", [0.0, 0.001, 0.1, 1.0])
def test_true_indices_are_those_of_flatnonzero(share: float) -> None:
    """Few or many, at the ends of words or not."""
    flags = np.random.default_rng(2).random(64 * 50) < share
    flags[[0, 7, 8, 63, 64, -1]] ^= True
    assert np.array_equal(true_indices(flags), np.flatnonzero(flags))


def test_the_message_facts_are_pymavlinks() -> None:
    """CRC extras and lengths are those of the installed pymavlink, for every message of both."""
    lengths = message_table.MAVLINK1_SHAPES.reshape(256, 256)
    common = 0
    for number, kind in mavlink2.mavlink_map.items():
        if message_table.EXTRAS[number] < 0:
            continue  # a message newer than ours
        common += 1
        assert message_table.EXTRAS[number] == kind.crc_extra, kind
        if number < 256:
            possible = np.flatnonzero(lengths[number])
            assert possible[0] == mavlink1.mavlink_map[number].unpacker.size, kind
            assert possible[-1] == kind.unpacker.size, kind
    assert common == (message_table.EXTRAS >= 0).sum()


@pytest.mark.parametrize("length", [3, 14, 32, 33, 38, 264])
def test_both_checksums_are_the_plain_one(length: int) -> None:
    """Column-wise and single CRC agree with the byte-wise one, for odd and even lengths."""
    chance = np.random.default_rng(length)
    checked = [chance.bytes(length) for _ in range(20)]
    sent = [part + slow_reader.crc(part + b"\x68").to_bytes(2, "little") for part in checked]
    sent[7] = sent[7][:-1] + bytes([sent[7][-1] ^ 128])
    frames = np.frombuffer(b"".join(b"\xfe" + each for each in sent), np.uint8).reshape(20, -1)
    assert np.flatnonzero(~are_crcs_valid(frames, 0x68)).tolist() == [7]
    assert [is_crc_valid(each, 0x68) for each in sent] == [index != 7 for index in range(20)]


@pytest.mark.parametrize("message", [STATUSTEXT, 999])
def test_frames_of_other_or_unknown_messages_are_not_positions(message: int) -> None:
    """Neither a text nor an unknown message gives a record."""
    unknown = bytearray(frame(STATUSTEXT, b"\3hello".ljust(51, b".")))
    unknown[7:10] = message.to_bytes(3, "little")
    assert not len(read(bytes(unknown), 1000).positions)
    assert not len(read(bytes(unknown), 1000).heartbeats)
