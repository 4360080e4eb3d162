"""What is taken for a DataFlash log."""

from __future__ import annotations

import pytest

from flight_replay.logs.dataflash.dataflash_marks import begins_dataflash, begins_dataflash_text
from tests.helpers.dataflash_writer import flight
from tests.helpers.log_writer import LogWriter
from tests.helpers.paths import SAMPLE


def test_a_log_is_known_by_its_first_record_or_by_formats_in_a_row() -> None:
    """Its beginning may be torn, and a log without FMT is one too."""
    data = bytes(flight().data)
    assert begins_dataflash(data[:4096])
    assert begins_dataflash(data[40:4096])
    assert begins_dataflash(data[5000:][data[5000:].find(b"\xa3\x95") :][:4096])
    assert begins_dataflash(data[:600])


@pytest.mark.parametrize("piece", [90, 200], ids=["LOG_DATA", "REMOTE_LOG_DATA_BLOCK"])
def test_a_telemetry_log_that_carries_pieces_of_one_is_none(piece: int) -> None:
    """A vehicle may send its log over the link: the frames cut it in pieces."""
    log, data = LogWriter(), bytes(flight().data)
    for at in range(0, len(data), piece):
        log.add(184 if piece == 200 else 120, bytes(6) + data[at : at + piece])
    assert not begins_dataflash(bytes(log.data[:4096]))
    assert begins_dataflash(data[:4096])


def test_other_logs_are_none() -> None:
    """Telemetry logs with or without stamps, an empty file, marks without records."""
    tlog = SAMPLE.read_bytes()[:4096]
    for head in (tlog, tlog[:50] + b"\xa3\x95\x80" + tlog[53:], b"", b"\xa3", bytes(4096)):
        assert not begins_dataflash(head)
        assert not begins_dataflash_text(head)
    assert not begins_dataflash(b"\xa3\x95\x12" + bytes(4093))


def test_a_log_as_text_is_known_by_its_formats() -> None:
    """Other lines may come first."""
    assert begins_dataflash_text(flight().text[:4096])
    assert begins_dataflash_text(b"ArduCopter V3.1\r\n\r\n" + flight().text[:1000].replace(b", ", b","))
    assert not begins_dataflash_text(b"time,lat,lon\n1,2,3\n")
