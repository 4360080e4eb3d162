"""Which positions are believed, and the reason that is given for the others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flight_replay.geometry.arrays import Flags
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.logs.tlog import Log, plausibility, read_log
from tests.helpers.log_writer import LogWriter
from tests.helpers.paths import other_log

FRAME = LocalFrame(47.4, 8.5)
Velocity = tuple[float, float, float]


class Flight:
    """A log of positions in metres north and east of a place."""

    def __init__(self, frame: LocalFrame = FRAME) -> None:
        self.log = LogWriter()
        self.frame = frame
        self.time_ms = 20_000

    def to(
        self, north_m: float, east_m: float = 0.0, after_s: float = 0.25, velocity: Velocity = (0, 0, 0)
    ) -> Flight:
        """Append a position ``after_s`` seconds after the last one."""
        self.time_ms += round(after_s * 1000)
        lat_deg, lon_deg = self.frame.to_degrees([north_m, east_m])
        self.log.position(self.time_ms, float(lat_deg), (float(lon_deg) + 180) % 360 - 180, velocity=velocity)
        return self

    def along(
        self, fixes: int, start_m: float = 0.0, speed_m_s: float = 5.0, reported: bool = True
    ) -> Flight:
        """Append a straight flight east at 4 Hz."""
        velocity = (0.0, speed_m_s if reported else 0.0, 0.0)
        for fix in range(fixes):
            self.to(0.0, start_m + 0.25 * speed_m_s * fix, velocity=velocity)
        return self

    def read(self, tmp_path: Path) -> Log:
        """The log, read back."""
        path = tmp_path / "made.tlog"
        path.write_bytes(self.log.data)
        return read_log(path)


def test_an_ordinary_flight_is_believed(tmp_path: Path) -> None:
    """Nothing is held against steps that the reported velocity explains."""
    log = Flight().along(100).read(tmp_path)
    assert (len(log.track), log.rejected) == (100, {})


@pytest.mark.parametrize("speed_m_s", [25.0, 60.0, 90.0])
def test_a_fast_flight_that_reports_its_speed_is_believed(tmp_path: Path, speed_m_s: float) -> None:
    """A racer's or a plane's fixes are far apart, and its velocity says so."""
    log = Flight().along(60, speed_m_s=speed_m_s).read(tmp_path)
    assert (len(log.track), log.rejected) == (60, {})


def test_a_gap_in_the_log_is_believed(tmp_path: Path) -> None:
    """A flight at 40 m/s goes on 104 m farther after 2.6 s without a record."""
    flight = Flight().along(20, speed_m_s=40.0).to(0, 19 * 10 + 104, after_s=2.6, velocity=(0, 40, 0))
    flight.to(0, 1_500, after_s=60.0)
    assert flight.read(tmp_path).rejected == {}


@pytest.mark.parametrize("lat_deg", [0.5, -16.0, 68.0])
def test_a_flight_across_the_antimeridian_is_believed(tmp_path: Path, lat_deg: float) -> None:
    """Longitude leaps from 180 to -180 degrees while the vehicle does not."""
    log = Flight(LocalFrame(lat_deg, 179.9999)).along(80).read(tmp_path)
    assert np.ptp(log.track.lon_deg) > 359
    assert log.rejected == {}


def test_an_outlier_is_left_out(tmp_path: Path) -> None:
    """A few positions 500 m away between good ones are rejected, and no others."""
    flight = Flight().along(30)
    for _ in range(3):
        flight.to(500.0, 30.0)
    log = flight.along(30, 38.0).read(tmp_path)
    assert log.rejected == {"impossible jump": 3}
    assert np.abs(log.track.north_east_m()[:, 0]).max() < 1


def test_a_false_start_before_a_jump_is_left_out(tmp_path: Path) -> None:
    """A cold receiver's first positions, 226 m away, go; the flight stays."""
    flight = Flight()
    for fix in range(25):
        flight.to(226.0 - fix, 0.0)
    log = flight.along(100).read(tmp_path)
    assert log.rejected == {"impossible jump": 25}
    assert len(log.track) == 100


def test_two_places_told_in_turns_leave_the_one_told_most(tmp_path: Path) -> None:
    """Of positions that flicker between two places 5 km apart, only those of one are believed."""
    flight = Flight().along(10)
    for fix in range(300):
        flight.to(5_000.0 if fix % 3 == 2 else 0.0, 20.0)
    log = flight.read(tmp_path)
    assert log.rejected == {"impossible jump": 100}


def test_thousands_of_jumps_are_judged_in_a_few_steps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two vehicles under one id jump at every record, and still cost little more than one."""
    flight, steps = Flight(), []
    for _ in range(500):
        flight.to(5_000.0).to(0.0)
    possible = plausibility._possible

    def counted(start: plausibility._Ends, end: plausibility._Ends) -> Flags:
        steps.append(len(start.time_s))
        return possible(start, end)

    monkeypatch.setattr(plausibility, "_possible", counted)
    assert flight.read(tmp_path).rejected == {"impossible jump": 500}
    assert len(steps) < 20


def test_a_jump_over_a_reboot_is_believed(tmp_path: Path) -> None:
    """A vehicle may be carried away before it is switched on again."""
    flight = Flight().along(20)
    flight.time_ms = 5_000
    log = flight.along(20, 3_000.0).read(tmp_path)
    assert (len(log.track), log.rejected) == (40, {})


def test_a_jump_within_a_later_boot_rejects_nothing_elsewhere(tmp_path: Path) -> None:
    """Each boot is judged for itself."""
    flight = Flight().along(5, start_m=9_000.0)
    flight.time_ms = 5_000
    log = flight.along(20).to(800.0).along(20, 25.0).read(tmp_path)
    assert log.rejected == {"impossible jump": 1}
    assert len(log.track) == 45


@pytest.mark.parametrize("fix_type", [0, 1, 2])
def test_positions_without_a_3d_fix_are_rejected(tmp_path: Path, fix_type: int) -> None:
    """What the vehicle sends between a receiver's word of a lost fix and the next good one does not count."""
    flight = Flight()
    flight.log.gps(3)
    flight.along(5).log.gps(fix_type)
    flight.along(4, 6.0).log.gps(fix_type)
    flight.along(3, 11.0).log.gps(4)
    log = flight.along(6, 15.0).read(tmp_path)
    assert log.rejected == {"no 3D fix": 7}
    assert len(log.track) == 11


def test_a_receivers_word_holds_until_the_next_one(tmp_path: Path) -> None:
    """A lost fix stays lost until the receiver says otherwise, however long that takes."""
    flight = Flight()
    flight.log.gps(0)
    flight.along(100).log.gps(3)
    log = flight.along(20, 125.0).read(tmp_path)
    assert log.rejected == {"no 3D fix": 100}
    assert len(log.track) == 20


def test_a_receivers_last_word_holds_for_a_while_only(tmp_path: Path) -> None:
    """A log that tells of the receiver just once, before it had a fix, keeps what follows later."""
    flight = Flight()
    flight.log.gps(1)
    log = flight.along(100).read(tmp_path)
    assert log.rejected == {"no 3D fix": 41}
    assert len(log.track) == 59


def test_another_vehicles_receiver_says_nothing(tmp_path: Path) -> None:
    """The fix of vehicle 2 is not that of vehicle 1."""
    flight = Flight()
    flight.log.data += LogWriter(system=2).gps(0).data
    assert flight.along(10).read(tmp_path).rejected == {}


@pytest.mark.parametrize(
    ("lat_deg", "lon_deg", "reason"),
    [
        (0.0101, -0.0073, "near 0,0"),
        (1e-7, 0.0, "near 0,0"),
        (90.0000001, 8.5, "outside the globe"),
        (-91.0, 8.5, "outside the globe"),
        (47.4, 180.0000001, "outside the globe"),
        (214.7483647, 214.7483647, "outside the globe"),
        (-214.7483648, -214.7483648, "outside the globe"),
    ],
)
def test_places_that_cannot_be_are_rejected(
    tmp_path: Path, lat_deg: float, lon_deg: float, reason: str
) -> None:
    """Next to 0, 0, or not on the globe."""
    flight = Flight().along(5)
    flight.log.position(21_500, lat_deg, lon_deg)
    assert flight.read(tmp_path).rejected == {reason: 1}


@pytest.mark.parametrize(("lat_deg", "lon_deg"), [(0.0, 8.5), (47.4, 0.0), (0.05, 0.05), (90.0, 180.0)])
def test_unusual_places_are_believed(tmp_path: Path, lat_deg: float, lon_deg: float) -> None:
    """The equator, Greenwich, 8 km from 0, 0 and the poles are places like any other."""
    flight = Flight(LocalFrame(lat_deg, lon_deg))
    for _ in range(5):
        flight.log.position(21_000, lat_deg, lon_deg)
    log = flight.read(tmp_path)
    assert (len(log.track), log.without_position, log.rejected) == (5, 0, {})


def test_the_wild_logs_false_positions_are_rejected() -> None:
    """Of two real logs the false starts go: near 0, 0 without a fix, and adrift before a jump."""
    teleport = read_log(other_log("wild/near-zero-then-teleport.tlog"))
    assert sum(teleport.rejected.values()) >= 24
    assert (teleport.track.north_east_m().max(axis=0) < 2_000).all()
    boots = read_log(other_log("wild/three-boots.tlog"))
    steps_m = np.linalg.norm(np.diff(boots.track.north_east_m(), axis=0), axis=1)
    assert steps_m[np.diff(boots.track.boot) == 0].max() < 15
