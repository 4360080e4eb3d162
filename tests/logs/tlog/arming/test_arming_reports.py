"""Arming and disarming count from the message of the moment, between the heartbeats that tell of it."""

from __future__ import annotations

import io
import struct

import numpy as np
import pytest

from flight_replay.logs.byte_source import OpenLog
from flight_replay.logs.tlog.arming import arming_reports
from flight_replay.logs.tlog.arming.arming_reports import with_reports
from flight_replay.logs.tlog.scan import scan
from flight_replay.logs.tlog.stretch_search import REACH
from tests.helpers.log_writer import ENCAPSULATED_DATA, START_US, STATUSTEXT, LogWriter, frame
from tests.helpers.track_files import read_bytes

COMMAND_ACK, ARM_DISARM, ACCEPTED, DENIED = 77, 400, 0, 2
UNTOLD = [0, 0, 0, 0, 1, 1, 1, 1]
"""Fixes of a flight whose arming only the heartbeat before the fifth tells of."""
Report = tuple[int, bytes]


def text(words: str) -> Report:
    """STATUSTEXT."""
    return STATUSTEXT, struct.pack("<B50s", 6, words.encode())


def ack(result: int = ACCEPTED, command: int = ARM_DISARM) -> Report:
    """COMMAND_ACK."""
    return COMMAND_ACK, struct.pack("<HB", command, result)


def flight(*reports: Report, version: int = 2, armed: bool = True, at: int = 2, **ids: int) -> LogWriter:
    """Eight fixes; the reports come before the third, or another, and a heartbeat before the fifth."""
    log = LogWriter(version).heartbeat(not armed)
    for fix in range(8):
        for message, payload in reports if fix == at else ():
            log.add(message, payload, **ids)
        if fix == 4:
            log.heartbeat(armed)
        log.position(1_000 + 250 * fix)
    return log.heartbeat(armed)


def states(log: LogWriter) -> list[int]:
    """The states of a log's fixes."""
    armed: list[int] = read_bytes(bytes(log.data)).track.armed.tolist()
    return armed


@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize(
    "report",
    [
        text("Arming motors"),
        text("ARMING MOTORS"),
        text("Throttle armed"),
        text("Armed by external command\t"),
        ack(),
    ],
    ids=["4.x", "3.x", "plane", "PX4", "acknowledged"],
)
def test_a_flight_begins_with_the_report_of_arming(version: int, report: Report) -> None:
    """Not with the heartbeat, which comes up to a second later."""
    assert states(flight(report, version=version)) == [0, 0, 1, 1, 1, 1, 1, 1]


@pytest.mark.parametrize(
    "report",
    [text("Disarming motors"), text("Throttle disarmed"), text("Disarmed by landing"), ack()],
    ids=["copter", "plane", "PX4", "acknowledged"],
)
def test_a_flight_ends_with_the_first_fix_after_the_report_of_disarming(report: Report) -> None:
    """As it does with the heartbeat."""
    assert states(flight(report, armed=False)) == [1, 1, 1, 0, 0, 0, 0, 0]


def test_the_first_of_several_reports_counts() -> None:
    """ArduPilot answers the command, and then tells everybody."""
    log = LogWriter().heartbeat(False).position(0).add(*ack()).position(250).add(*text("Arming motors"))
    assert states(log.position(500).heartbeat(True).position(750)) == [0, 1, 1, 1]


@pytest.mark.parametrize(
    "report",
    [
        text("PreArm: Need 3D Fix"),
        text("Arm: Throttle too high"),
        text("Disarming motors"),
        text("say Arming motors"),
        ack(DENIED),
        ack(command=22),
    ],
)
def test_other_messages_tell_nothing_of_arming(report: Report) -> None:
    """Refusals, the opposite, quotations and other commands."""
    assert states(flight(report)) == UNTOLD


@pytest.mark.parametrize(("system", "component"), [(2, 1), (1, 191), (255, 190)])
def test_others_reports_tell_nothing_of_arming(system: int, component: int) -> None:
    """Those of another vehicle, or of a program on board or on the ground."""
    assert states(flight(text("Arming motors"), ack(), system=system, component=component)) == UNTOLD


@pytest.mark.parametrize("at", [0, 5, 7])
def test_a_report_counts_only_between_the_heartbeats_of_the_change(at: int) -> None:
    """The first heartbeat after it decides, whatever it says, and one that never comes does not."""
    log = LogWriter().add(*text("Arming motors"))
    log.data += flight(text("Disarming motors"), at=at).data
    assert states(log) == UNTOLD


def test_a_report_inside_another_record_is_none() -> None:
    """Such as a log that is downloaded over the link."""
    inner = frame(*text("Arming motors"))
    assert states(flight((ENCAPSULATED_DATA, b"\1\1" + inner))) == UNTOLD


def test_a_damaged_report_is_none() -> None:
    """Its CRC is wrong."""
    log = flight(text("Arming motors"))
    at = log.data.index(b"Arming")
    log.data[at - 1] ^= 1
    assert states(log) == UNTOLD


def test_a_report_far_before_the_heartbeat_is_none() -> None:
    """A link that was lost for long."""
    log = LogWriter().heartbeat(False).position(0).add(*text("Arming motors")).position(250)
    log.data += bytes(REACH)
    assert states(log.position(500).heartbeat(True).position(750)) == [0, 0, 0, 1]


@pytest.mark.parametrize("reach", [REACH, 300])
def test_reports_are_found_in_blocks_of_any_length(reach: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Several vehicles that arm and disarm many times, in blocks that begin anywhere."""
    monkeypatch.setattr(arming_reports, "REACH", reach)
    chance, log, stamp_us = np.random.default_rng(1), LogWriter(), START_US
    for _ in range(400):
        log.stamp_us = stamp_us = stamp_us + 10_000
        system, kind = int(chance.integers(1, 4)), int(chance.integers(6))
        report = [text("Arming motors"), text("Disarming motors"), ack()][kind % 3]
        if kind < 3:
            log.add(*report, system=system)
        elif kind < 5:
            log.heartbeat(bool(chance.integers(2)), system=system)
        else:
            log.position(stamp_us // 1000 % 1_000_000)
    expected = moved(log, 1 << 20)
    assert len(np.unique(expected)) > 50
    for block_length in (400, 1_000, 3_333):
        assert moved(log, block_length) == expected


def moved(log: LogWriter, block_length: int) -> list[int]:
    """Where each vehicle's changes of state are in a log, read in blocks."""
    records, _ = scan(OpenLog("made", io.BytesIO(bytes(log.data))), block_length=block_length)
    found = []
    for system in (1, 2, 3):
        key = system << 8 | 1
        own = records.heartbeats.select(records.heartbeats.vehicle == key)
        told = with_reports(own, records.reports.select(records.reports.vehicle == key))
        found += told.offset[1:][np.diff(told.armed)].tolist()
    return found
