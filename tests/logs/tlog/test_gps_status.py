"""Positions without a 3D fix, and implausible positions in telemetry logs."""

from __future__ import annotations

import io
import struct
from pathlib import Path

import numpy as np
import pytest

from flight_replay.logs.byte_source import OpenLog
from flight_replay.logs.read_log import read_log
from flight_replay.logs.recording import Recording
from flight_replay.logs.tlog.gps_status import lacks_3d_fix
from flight_replay.logs.tlog.scan import scan
from tests.helpers.log_writer import LogWriter
from tests.helpers.paths import other_log

GPS2_RAW = 124


class Flight:
    """A log of positions 5 m apart, 4 Hz."""

    def __init__(self, system: int = 1, time_ms: int = 20_000) -> None:
        self.log = LogWriter(system=system)
        self.time_ms = time_ms
        self.fixes = 0

    def along(self, fixes: int) -> Flight:
        """Append positions."""
        for _ in range(fixes):
            self.log.position(self.time_ms, 47.4 + 4.5e-5 * self.fixes, 8.5)
            self.time_ms += 250
            self.fixes += 1
        return self

    def gps(self, fix_type: int) -> Flight:
        """Append what the receiver says of its fix."""
        self.log.gps(fix_type)
        return self

    def read(self, tmp_path: Path) -> Recording:
        """The log, read back."""
        path = tmp_path / "made.tlog"
        path.write_bytes(self.log.data)
        return read_log(path)


def test_a_vehicle_without_a_receiver_knows_its_place_by_other_means(tmp_path: Path) -> None:
    """It reports type 0 throughout; one that had a receiver is not believed while that is gone."""
    assert len(Flight().gps(0).along(5).gps(0).along(4).read(tmp_path).track) == 9
    assert len(Flight().gps(0).along(5).gps(1).along(4).gps(3).along(2).read(tmp_path).track) == 2


@pytest.mark.parametrize("fix_type", [0, 1, 2])
def test_positions_without_a_3d_fix_are_rejected(tmp_path: Path, fix_type: int) -> None:
    """What the vehicle sends between a receiver's status "no fix" and the next good one does not count."""
    flight = Flight().gps(3).along(5).gps(fix_type).along(4).gps(fix_type).along(3).gps(4).along(6)
    log = flight.read(tmp_path)
    assert log.rejected == {"no 3D fix": 7}
    assert log.track.time_s[[4, 5]].tolist() == [21.0, 23.0]
    assert len(log.track) == 11


def test_a_status_holds_until_the_next_one(tmp_path: Path) -> None:
    """A lost fix stays lost until the receiver says otherwise, however long that takes."""
    log = Flight().gps(0).along(100).gps(3).along(20).read(tmp_path)
    assert log.rejected == {"no 3D fix": 100}
    assert len(log.track) == 20


def test_the_last_status_holds_for_a_while_only(tmp_path: Path) -> None:
    """A log that tells of the receiver just once, before it had a fix, keeps what follows 10 s later."""
    log = Flight().gps(1).along(100).read(tmp_path)
    assert log.rejected == {"no 3D fix": 41}
    assert len(log.track) == 59
    assert Flight().gps(3).along(100).gps(1).read(tmp_path).rejected == {}


def test_a_late_record_does_not_make_the_last_status_hold_for_longer(tmp_path: Path) -> None:
    """The 10 s end at the first record behind them, whatever an older one says that follows."""
    flight = Flight().along(2).gps(1).along(60)
    flight.log.position(25_000, 47.4, 8.5).position(35_000, 47.4, 8.5)
    assert flight.read(tmp_path).rejected == {"no 3D fix": 41}


def test_each_vehicle_has_its_own_receiver(tmp_path: Path) -> None:
    """The fix of a vehicle is not that of others, whose ids are lower or higher."""
    first, second, third = Flight(1).gps(3).along(30), Flight(2).gps(1).along(90), Flight(3).along(50)
    log = Flight(1)
    log.log.data += LogWriter(system=4).gps(0).data + third.log.data + second.log.data + first.log.data
    read = log.read(tmp_path)
    assert [(each.system, each.fixes) for each in read.vehicles] == [(3, 50), (2, 49), (1, 30)]


def test_implausible_places_are_rejected_with_their_reason(tmp_path: Path) -> None:
    """Each position is judged by its own vehicle's clock, velocity and boot."""
    flight = Flight().along(20)
    flight.log.position(25_000, 47.41, 8.5).position(25_250, 0.001, 0.001).position(25_500, 91.0, 8.5)
    flight.log.position(25_750, 47.402, 8.5, velocity=(100.0, 0.0, 0.0)).position(4_000, 47.6, 8.5)
    log = flight.read(tmp_path)
    assert log.rejected == {"impossible jump": 1, "near 0,0": 1, "outside the globe": 1}
    assert len(log.track) == 22


def test_false_positions_of_real_logs_are_rejected() -> None:
    """Of two real logs the false starts go: near 0, 0 without a fix, and adrift before a jump."""
    teleport = read_log(other_log("wild/near-zero-then-teleport.tlog"))
    assert sum(teleport.rejected.values()) >= 24
    assert (teleport.track.north_east_m().max(axis=0) < 2_000).all()
    boots = read_log(other_log("wild/three-boots.tlog"))
    steps_m = np.linalg.norm(np.diff(boots.track.north_east_m(), axis=0), axis=1)
    assert steps_m[np.diff(boots.track.boot) == 0].max() < 15


def gps2(flight: Flight, fix_type: int) -> Flight:
    """Append what the second receiver says of its fix."""
    payload = struct.pack("<QiiiIHHHHBBB", 0, 1, 2, 3, 4, 5, 6, 7, 8, fix_type, 9, 10)
    flight.log.add(GPS2_RAW, payload if flight.log.version == 1 else payload + bytes([1]))
    return flight


@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize("first", [0, 1, 2])
def test_a_second_receiver_with_a_3d_fix_will_do(tmp_path: Path, version: int, first: int) -> None:
    """Such as where the first one is dead, which says so all along."""
    flight = Flight()
    flight.log.version = version
    for _ in range(20):
        gps2(flight.gps(first), 3).along(4)
    log = flight.read(tmp_path)
    assert (log.rejected, len(log.track)) == ({}, 80)


def test_a_position_lacks_a_fix_if_no_receiver_has_one(tmp_path: Path) -> None:
    """Whichever lost it first; what the second one said before the first one lost it counts."""
    flight = gps2(gps2(Flight().gps(3), 3).along(4).gps(3), 3).along(3).gps(1).along(2)
    gps2(flight, 1).along(5).gps(1).along(6)
    gps2(flight, 4).along(7).gps(3).along(8)
    gps2(flight, 0).along(9)
    log = flight.read(tmp_path)
    assert (log.rejected, len(log.track)) == ({"no 3D fix": 11}, 33)


def test_the_last_status_of_a_second_receiver_holds_for_a_while_only(tmp_path: Path) -> None:
    """One that says nothing any more may be dead, too."""
    flight = gps2(Flight().gps(1).along(10), 3)
    for _ in range(50):
        flight.gps(1).along(2)
    assert flight.read(tmp_path).rejected == {"no 3D fix": 10 + 59}


def test_a_vehicles_second_receiver_is_not_anothers(tmp_path: Path) -> None:
    """What another vehicle's says does not help."""
    first = Flight(1).gps(3).along(30)
    second = Flight(2).gps(1).along(5)
    first.log.data += gps2(Flight(3), 3).log.data + second.log.data
    read = first.read(tmp_path)
    assert [(each.system, each.fixes) for each in read.vehicles] == [(1, 30), (2, 0)]


@pytest.mark.parametrize("block_length", [400, 1_000, 5_000])
def test_a_second_receiver_is_found_in_blocks_of_any_length(block_length: int) -> None:
    """Wherever they begin, within reach of what the first receiver says."""
    chance, flight = np.random.default_rng(2), Flight()
    for _ in range(60):
        gps2(flight.gps(int(chance.integers(2, 4))), int(chance.integers(2, 4))).along(2)
    whole, parts = (
        scan(OpenLog("made", io.BytesIO(bytes(flight.log.data))), block_length=length)[0]
        for length in (1 << 20, block_length)
    )
    lacks = [
        lacks_3d_fix(each.positions, each.gps, each.gps2, each.positions.time_ms / 1e3)
        for each in (whole, parts)
    ]
    assert 0 < lacks[0].sum() < len(lacks[0])
    assert np.array_equal(lacks[0], lacks[1])
