"""The records of DataFlash logs: every value as pymavlink has it, and more where that stops."""

from __future__ import annotations

import gzip
import io
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from pymavlink import DFReader

from flight_replay.exceptions import LogError
from flight_replay.logs.byte_source import OpenLog
from flight_replay.logs.dataflash.collected import MESSAGES
from flight_replay.logs.dataflash.message_rows import PackedRows
from flight_replay.logs.dataflash.record_stream import BLOCK_LENGTH, RecordStream
from tests.helpers import slow_dataflash
from tests.helpers.dataflash_writer import COPTER_33, DataflashWriter, flight, fmt
from tests.helpers.paths import DATAFLASH, OTHER_LOGS

HELD_AGAINST_PYMAVLINK = ("POS", "GPS", "ATT", "XKF1", "NKF1", "EKF1", "ARM", "EV", "ORGN", "PARM", "MSG")


def rows_of(
    data: bytes, names: tuple[str, ...] = tuple(MESSAGES), block_length: int = BLOCK_LENGTH
) -> tuple[list[PackedRows], RecordStream]:
    """The records of some messages, block by block, and the stream that gave them."""
    stream = RecordStream(OpenLog("log", io.BytesIO(data)), names, None, block_length)
    return [rows for block in stream.blocks() for rows in block], stream


def our_values(data: bytes, names: tuple[str, ...]) -> dict[tuple[str, str], list[float | bytes]]:
    """All values by message and column."""
    found: dict[tuple[str, str], list[float | bytes]] = defaultdict(list)
    for rows in rows_of(data, names)[0]:
        for column in rows.columns:
            numbers = rows.number(column)
            values = rows.text(column) if numbers is None else numbers.tolist()
            assert values is not None
            found[rows.name, column] += values
    return dict(found)


def pymavlink_values(path: Path, names: tuple[str, ...]) -> dict[tuple[str, str], list[float | bytes]]:
    """The same by pymavlink."""
    found: dict[tuple[str, str], list[float | bytes]] = defaultdict(list)
    log = DFReader.DFReader_binary(str(path))
    while (message := log.recv_match(type=list(names))) is not None:
        for column in message.get_fieldnames():
            value = getattr(message, column)
            name = (message.get_type(), column)
            found[name].append(value.encode("latin-1") if isinstance(value, str) else float(value))
    log.close()
    return dict(found)


def assert_as_pymavlink(path: Path, data: bytes) -> int:
    """Hold all values against pymavlink's, bit by bit; how many there are."""
    path.write_bytes(data)
    expected, found = pymavlink_values(path, HELD_AGAINST_PYMAVLINK), our_values(data, HELD_AGAINST_PYMAVLINK)
    assert found.keys() == expected.keys()
    for name, values in expected.items():
        ours = [value.split(b"\0")[0] if isinstance(value, bytes) else value for value in found[name]]
        if isinstance(values[0], bytes):
            assert len(ours) == len(values), name  # pymavlink reads texts in more than one way
        else:
            np.testing.assert_array_equal(np.array(ours, float), np.array(values, float), str(name))
    return sum(len(values) for values in expected.values())


def test_every_value_of_a_real_log_is_as_pymavlink_reads_it(tmp_path: Path) -> None:
    """ArduCopter 4.6: POS, GPS, ATT, XKF1, ARM, EV, ORGN and PARM are equal to the last bit."""
    data = gzip.decompress((DATAFLASH / "square.bin.gz").read_bytes())
    assert assert_as_pymavlink(tmp_path / "square.bin", data) > 50_000


def test_every_value_of_a_made_log_is_as_pymavlink_reads_it(tmp_path: Path) -> None:
    """The columns of 3.3, which have no microseconds, are read too."""
    log = DataflashWriter(dict(COPTER_33))
    for number in range(50):
        log.add("GPS", Status=3, TimeMS=number * 200, Week=1800, Lat=47.4, Lng=8.5 - number * 1e-5, T=number)
        log.add("ATT", TimeMS=number * 200, Yaw=number * 7.0).add("EV", Id=10 + number % 2)
        log.add("EKF1", TimeMS=number * 200, VN=number / 7)
    assert assert_as_pymavlink(tmp_path / "made.bin", bytes(log.data)) > 1_000


@pytest.mark.parametrize("path", sorted(OTHER_LOGS.glob("**/*.bin")), ids=lambda path: path.name)
def test_every_value_of_other_logs_is_as_pymavlink_reads_it(path: Path, tmp_path: Path) -> None:
    """The same for logs of other firmwares, where they are at hand."""
    data = path.read_bytes()
    if len(data) < 1_000:
        pytest.skip("too short for pymavlink")
    assert assert_as_pymavlink(tmp_path / "copy.bin", data) > 0


def test_an_unknown_type_in_the_middle_ends_pymavlinks_reading_but_not_ours(tmp_path: Path) -> None:
    """Records behind one of a type without FMT are found; pymavlink stops there without a word."""
    first, second = flight(10.0), flight(20.0)
    junk = b"\xa3\x95\xf3" + bytes(range(40))
    path = tmp_path / "log.bin"
    path.write_bytes(first.data + junk + second.data)
    ours = our_values(path.read_bytes(), ("POS",))["POS", "TimeUS"]
    theirs = pymavlink_values(path, ("POS",))["POS", "TimeUS"]
    assert len(ours) == 80
    assert len(theirs) < 80
    assert ours[: len(theirs)] == theirs
    assert rows_of(path.read_bytes())[1].read_bytes == len(first.data) + len(second.data)


@pytest.mark.parametrize("block_length", [300, 1000, 4096])
def test_blocks_of_any_length_give_the_same_records(block_length: int) -> None:
    """Records that reach over the end of a block are read once, and all bytes are counted."""
    data = bytes(flight(late=True).data)
    whole, _ = rows_of(data)
    parts, stream = rows_of(data, block_length=block_length)
    assert sorted(at for rows in parts for at in rows.offset) == sorted(
        at for rows in whole for at in rows.offset
    )
    assert stream.length == stream.read_bytes == len(data)


def test_a_format_counts_from_where_it_is_told() -> None:
    """FMT may come late, and a type may become another message: what was before is read as it was."""
    log = DataflashWriter(late=True)
    log.add("EV", TimeUS=1, Id=10).add("POS", TimeUS=2, Lat=1.0)
    log.formats["EV"], log.formats["POS"] = (72, "QB", "TimeUS,Id"), (181, "QLL", "TimeUS,Lat,Lng")
    log.define("EV").define("POS").add("EV", TimeUS=3, Id=11).add("POS", TimeUS=4, Lat=2.0)
    assert our_values(bytes(log.data), ("EV", "POS")) == {
        ("EV", "TimeUS"): [1, 3],
        ("EV", "Id"): [10, 11],
        ("POS", "TimeUS"): [2, 4],
        ("POS", "Lat"): [1.0, 2.0],
        ("POS", "Lng"): [0.0, 0.0],
        ("POS", "Alt"): [0.0],
        ("POS", "RelHomeAlt"): [0.0],
        ("POS", "RelOriginAlt"): [0.0],
    }


def test_a_torn_record_is_left_out() -> None:
    """A record that no header follows where it ends is none; those around it are read."""
    log = DataflashWriter()
    log.add("EV", TimeUS=1, Id=1)
    begin = len(log.data)
    log.add("POS", TimeUS=2, Lat=1.0)
    torn = log.data[: begin + 15]
    log.data = torn
    log.add("EV", TimeUS=3, Id=3)
    found = our_values(bytes(log.data), ("EV", "POS"))
    assert found == {("EV", "TimeUS"): [1, 3], ("EV", "Id"): [1, 3]}


def test_what_looks_like_a_header_inside_a_record_is_none() -> None:
    """A header in the text of a message begins no record."""
    log = DataflashWriter(formats={"MSG": (59, "QZ", "TimeUS,Message"), "EV": (181, "QB", "TimeUS,Id")})
    log.add("EV", TimeUS=1, Id=1).add("MSG", TimeUS=2)
    log.data[-40:-28] = b"\xa3\x95\xb5" + bytes(9)
    log.data[-28:-26] = b"\xa3\x95"
    log.add("EV", TimeUS=3, Id=3)
    assert our_values(bytes(log.data), ("EV",))["EV", "Id"] == [1, 3]


@pytest.mark.parametrize("seed", range(4))
def test_long_chains_of_headers_in_records_are_walked_as_the_plain_reader_does(seed: int) -> None:
    """Where nearly every record holds headers, the walk's long way is found part by part."""
    chance = np.random.default_rng(seed)
    kinds = {kind: 4 + 2 * number for number, kind in enumerate((0xA3, 13, 14, 15)[: seed + 1])}
    log = DataflashWriter(late=True)
    log.data += b"".join(
        fmt(
            kind,
            length,
            "EV" if kind == 13 else "ARM",
            "B" * (length - 3),
            ",".join("abcdefgh"[: length - 3]),
        )
        for kind, length in kinds.items()
    )
    pieces = [b"\xa3\x95" + bytes([kind]) for kind in kinds] + [b"\xa3\x95", b"\x00"]
    data = (
        bytes(log.data)
        + pieces[0]
        + b"".join(pieces[number] for number in chance.integers(0, len(pieces), 40_000))
    )
    expected = [at for at, name, _ in slow_dataflash.records(data) if name in MESSAGES]
    assert len(expected) > 1_000
    assert sorted(int(at) for rows in rows_of(data)[0] for at in rows.offset) == expected


def test_a_damaged_format_does_not_replace_a_good_one() -> None:
    """FMT whose columns do not add up to its length is not taken where there is a better one."""
    log = DataflashWriter().add("EV", TimeUS=1, Id=1)
    log.data += fmt(181, 12, "EV", "QBB", "TimeUS,Id,No")
    log.add("EV", TimeUS=3, Id=3)
    assert our_values(bytes(log.data), ("EV",))["EV", "Id"] == [1, 3]


@pytest.mark.parametrize("length", [0, 1, 2, 3])
def test_a_format_without_a_payload_is_not_taken(length: int) -> None:
    """A length that is not even that of a header is no length to walk by."""
    log = DataflashWriter(late=True)
    log.data += fmt(181, length, "EV", "", "")
    log.data += b"\xa3\x95\xb5" * 50
    log.add("POS", TimeUS=3)
    assert our_values(bytes(log.data), ("EV", "POS"))["POS", "TimeUS"] == [3]


def test_formats_that_never_stop_changing_are_refused() -> None:
    """Tens of thousands of different definitions are no autopilot's."""
    data = b"".join(fmt(181, 12, "EV", "QB", f"TimeUS,{number}") for number in range(17_000))
    with pytest.raises(LogError, match="log defines its records anew more than 16384 times"):
        rows_of(data)


def test_the_plain_reader_agrees_on_a_real_log() -> None:
    """The walk over every byte offset finds the same records."""
    data = gzip.decompress((DATAFLASH / "square.bin.gz").read_bytes())[:500_000]
    expected = [(at, name) for at, name, _ in slow_dataflash.records(data) if name in MESSAGES]
    found = sorted((int(at), rows.name) for rows in rows_of(data)[0] for at in rows.offset)
    assert found == expected
