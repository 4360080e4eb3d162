"""What is read of DataFlash logs, by the rules of docs/logs.md; each also holds for the log as text."""

from __future__ import annotations

import gzip
import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from flight_replay.exceptions import LogError
from flight_replay.logs.flights import find_flights
from flight_replay.logs.read_log import read_log
from flight_replay.logs.recording import Recording
from flight_replay.logs.track import Armed
from flight_replay.logs.vehicles import VehicleId
from tests.helpers.dataflash_writer import COPTER_33, DataflashWriter, flight, fmt

Read = Callable[[DataflashWriter], Recording]


@pytest.fixture(params=["bin", "text"])
def read(request: pytest.FixtureRequest, tmp_path: Path) -> Read:
    """Reads a log as bytes, or as text."""

    def read_as(log: DataflashWriter) -> Recording:
        path = tmp_path / "flight"
        path.write_bytes(log.data if request.param == "bin" else log.text)
        recording = read_log(path)
        assert recording.format == ("dataflash" if request.param == "bin" else "dataflash-text")
        return recording

    return read_as


def unarmed() -> DataflashWriter:
    """A log that tells nothing of arming."""
    return DataflashWriter().add("MSG", Message="ArduCopter V4.6.0 (abcdef01)").home(9.0)


def test_a_flight_is_read_with_all_that_the_log_tells(read: Read) -> None:
    """Times, places, heights, velocities, headings, arming, the vehicle and its start."""
    recording = read(flight())
    track = recording.track
    np.testing.assert_allclose(track.time_s, 10 + 0.1 * np.arange(40), atol=1e-6)
    np.testing.assert_allclose(track.lat_deg, 47.4 + 1e-5 * np.arange(40), atol=1e-7)
    np.testing.assert_allclose(track.lon_deg, 8.5, atol=1e-7)
    np.testing.assert_allclose(track.alt_m, 10.0)
    np.testing.assert_allclose(track.amsl_m, 410.0)
    np.testing.assert_allclose(track.heading_deg, 90.0 + np.arange(40), atol=0.01)
    for column, value in ((track.north_m_s, 3.0), (track.east_m_s, -1.0), (track.up_m_s, 0.5)):
        np.testing.assert_allclose(column, value)
    assert (track.armed == Armed.YES).all()
    assert (recording.firmware, recording.vehicle_type) == ("ArduCopter V4.6.0", "hexacopter")
    assert recording.is_multicopter is True
    assert recording.vehicle is not None
    assert (recording.vehicle.id, recording.vehicle.fixes) == (VehicleId(7, 1), 40)
    # Week 2300 of GPS began on 2024-02-04; the clocks of the log and of the week agree, less 18 leap seconds.
    assert recording.start_utc_s == pytest.approx(1_707_004_800 + 10 - 18, abs=0.01)
    assert recording.notes == ()


def test_the_velocities_are_those_of_the_core_in_use(read: Read) -> None:
    """From where XKF4 tells of another core, its velocities count."""
    log = flight()
    log.core = 1
    for number in range(40, 60):
        log.fix(10 + 0.1 * number, number)
    north_m_s = read(log).track.north_m_s
    assert set(north_m_s[:40].tolist()) == {3.0}
    assert set(north_m_s[41:].tolist()) == {53.0}


def test_without_velocities_the_positions_tell_them(read: Read) -> None:
    """EK3_LOG_LEVEL leaves XKF1 out: flights are found by motion all the same."""
    log = unarmed()
    for number in range(60):
        time_s, place = 10 + 0.1 * number, {"Lat": 47.4 + number * 1e-5, "Lng": 8.5}
        log.add("POS", TimeUS=round(time_s * 1e6), Alt=410.0, RelHomeAlt=10.0, RelOriginAlt=10.0, **place)
    track = read(log).track
    assert track.north_m_s == pytest.approx(11.12, abs=0.1)
    assert [each.fixes for each in find_flights(track)] == [60]


def test_without_pos_the_receivers_positions_count(read: Read) -> None:
    """One receiver's: the one in use; with velocities from its speed and course, less those without a fix."""
    log = unarmed()
    log.receiver(9.8, Status=1, Lat=0, Lng=0).receiver(9.9, Status=2)
    for number in range(30):
        time_s = 10 + 0.2 * number
        log.receiver(time_s, number, alt_m=float(number), Spd=2.0, GCrs=90.0, VZ=-1.5)
        log.receiver(time_s + 0.05, number, I=1, U=0, Lat=47.5)
        log.add("ATT", TimeUS=round(time_s * 1e6) + 20_000, Yaw=45.0)
    recording = read(log)
    track = recording.track
    assert len(track) == 30
    assert recording.without_position == 1
    assert recording.rejected == {"no 3D fix": 1}
    np.testing.assert_allclose(track.lat_deg, 47.4 + 1e-5 * np.arange(30), atol=1e-7)
    np.testing.assert_allclose(track.alt_m - track.alt_m[0], np.arange(30))
    np.testing.assert_allclose(track.east_m_s, 2.0)
    np.testing.assert_allclose(track.north_m_s, 0.0, atol=1e-6)
    np.testing.assert_allclose(track.up_m_s, 1.5)
    np.testing.assert_allclose(track.heading_deg, 45.0)
    assert recording.notes[0] == "Positions are those of the GPS receiver: POS is missing"


def test_where_most_of_pos_is_lost_the_receivers_positions_count(read: Read) -> None:
    """POS for less than four fifths of the seconds in which the receiver has a fix."""
    log = unarmed()
    for number in range(100):
        if number < 60:
            log.fix(10 + 0.1 * number, number)
        log.receiver(10 + 0.1 * number, number)
    recording = read(log)
    assert len(recording.track) == 100
    assert recording.notes[0] == "Positions are those of the GPS receiver: POS has only 6 of its 10 s"


def test_heights_are_above_the_home_of_each_flight(read: Read) -> None:
    """RelHomeAlt follows a home that moves; what it was before one was set is nonsense."""
    log = DataflashWriter().fix(9.0, alt_m=-869.0).arm(9.5).home(9.5)
    for number in range(10):
        log.fix(10 + 0.1 * number, number, alt_m=float(number))
    log.arm(11.0, False).arm(30.0)
    for number in range(10):
        log.fix(30 + 0.1 * number, number, alt_m=float(number), home_m=395.0)
    track = read(log).track
    np.testing.assert_allclose(track.alt_m[1:], [*range(10), *range(10)])
    assert track.alt_m[0] == pytest.approx(-469.0 - 400.0)
    assert track.amsl_m[11] == 395.0


def test_heights_of_a_log_without_home_are_above_the_first_fix_of_each_flight(read: Read) -> None:
    """POS of 3.4 has no height above home that counts, nor has a receiver; a note says so."""
    log = DataflashWriter()
    log.formats["POS"] = (72, "QLLff", "TimeUS,Lat,Lng,Alt,RelAlt")
    log.begin()
    for start_s, home_m in ((10, 400.0), (30, 390.0)):
        log.arm(start_s)
        for number in range(10):
            log.add(
                "POS",
                TimeUS=round((start_s + 0.1 * number) * 1e6),
                Lat=47.4,
                Lng=8.5 + 1e-5 * number,
                Alt=home_m + 2 * number,
            )
        log.arm(start_s + 1, False)
    recording = read(log)
    np.testing.assert_allclose(recording.track.alt_m, [*range(0, 20, 2), *range(0, 20, 2)])
    assert "The log does not tell home; heights are above the first fix of each flight" in recording.notes


def test_a_log_of_3_3_is_read(read: Read) -> None:
    """T of GPS is the autopilot's clock; events have no time; the receiver's RelAlt is above home."""
    log = DataflashWriter(dict(COPTER_33)).add("MSG", Message="APM:Copter V3.3 (d6053245)")
    log.add("MSG", Message="Frame: QUAD").parameter("SYSID_THISMAV", 1)
    for start_ms in (100_000, 150_000, 200_000):
        log.add("EV", Id=10)
        for number in range(20):
            time_ms = start_ms + 200 * number
            log.add("ATT", TimeMS=time_ms - 5, Yaw=10.0)
            log.add("EKF1", TimeMS=time_ms - 5, VN=1.0)
            place = {
                "Lat": 47.4,
                "Lng": 8.5 + number * 1e-5,
                "RelAlt": 0.5 * number,
                "Alt": 400 + 0.5 * number,
            }
            log.add("GPS", Status=3, TimeMS=432_000_000 + time_ms, Week=1800, T=time_ms, Spd=4.0, **place)
    recording = read(log)
    assert [flight.fixes for flight in find_flights(recording.track)] == [19, 19, 20]
    assert recording.track.time_s[0] == 100.0
    np.testing.assert_allclose(recording.track.alt_m, np.tile(0.5 * np.arange(20), 3))
    np.testing.assert_allclose(recording.track.heading_deg, 10.0)
    assert (recording.firmware, recording.vehicle_type) == ("APM:Copter V3.3", "quadcopter")


def test_before_its_first_event_a_vehicle_was_in_the_opposite_state(read: Read) -> None:
    """A log that begins with the flight often has but the event of disarming."""
    log = unarmed()
    for number in range(10):
        log.fix(10 + 0.1 * number, number)
    log.arm(11.0, False)
    for number in range(10, 15):
        log.fix(10 + 0.1 * number, number)
    armed = read(log).track.armed
    assert armed.tolist() == [Armed.YES] * 10 + [Armed.NO] * 5


@pytest.mark.parametrize(
    ("log_disarmed", "expected"), [(0, Armed.YES), (1, Armed.UNKNOWN), (None, Armed.UNKNOWN)]
)
def test_a_log_without_events(read: Read, log_disarmed: int | None, expected: Armed) -> None:
    """It was armed throughout if it is written while armed only; else nobody knows."""
    log = unarmed()
    if log_disarmed is not None:
        log.parameter("LOG_DISARMED", log_disarmed)
    for number in range(10):
        log.fix(10 + 0.1 * number, number)
    assert set(read(log).track.armed.tolist()) == {expected}


def test_a_second_arming_without_a_disarming_is_a_second_flight(read: Read) -> None:
    """Logging pauses while disarmed, sometimes before the disarming is written."""
    log = unarmed().arm(10)
    for start_s in (10, 40):
        for number in range(10):
            log.fix(start_s + 0.1 * number, number)
        if start_s == 10:
            log.arm(40.0)
            log.add("ARM", TimeUS=40_000_100, ArmState=1)
    assert [flight.fixes for flight in find_flights(read(log).track)] == [9, 10]


def test_one_arming_that_two_records_tell_of_is_one(read: Read) -> None:
    """EV and ARM come together, with a position between them at most."""
    log = unarmed().arm(9.9).fix(10.0).add("ARM", TimeUS=10_050_000, ArmState=1)
    for number in range(1, 10):
        log.fix(10 + 0.1 * number, number)
    assert [flight.fixes for flight in find_flights(read(log).track)] == [10]


def test_boots_in_one_file_are_sections_of_their_own(read: Read) -> None:
    """A clock that falls, or a log that begins anew: time goes on by the receiver, events do not."""
    log, later = flight(100.0), flight(20.0)
    log.data += later.data
    log.lines += later.lines
    track = read(log).track
    assert track.boot.tolist() == [0] * 40 + [1] * 40
    assert (np.diff(track.time_s) >= 0).all()
    assert track.time_s[0] == 100.0
    assert [flight.fixes for flight in find_flights(track)] == [40, 40]


def test_the_receiver_tells_how_long_a_boot_took(read: Read) -> None:
    """Between the last fix of one boot and the first of the next, UTC went on by 60 s."""
    log = flight(100.0)
    later = DataflashWriter().home(5.0)
    for number in range(10):
        later.fix(5 + 0.1 * number, number).receiver(5 + 0.1 * number, GMS=163_900 + 100 * number)
    log.data += later.data
    log.lines += later.lines
    time_s = read(log).track.time_s
    assert time_s[40] - time_s[39] == pytest.approx(60.0, abs=1e-3)


def test_a_receiver_whose_time_stands_still_is_no_boot(read: Read) -> None:
    """Times of different records may be apart; only a clock that falls in one kind of them was set back."""
    log = unarmed()
    for number in range(40):
        log.fix(10 + 0.1 * number, number).receiver(2.0, number, I=1, U=0)
    assert set(read(log).track.boot.tolist()) == {0}


def test_a_single_record_with_a_damaged_time_is_left_out(read: Read) -> None:
    """It fits neither the record before nor the one behind; no boot is made of it."""
    log = unarmed()
    for number in range(20):
        log.fix({5: 70_000.0, 9: 1.0, 15: 3e9}.get(number, 10 + 0.1 * number), number)
    recording = read(log)
    assert len(recording.track) == 17
    assert set(recording.track.boot.tolist()) == {0}
    assert "Positions left out because their time or height cannot be right: 3" in recording.notes


def test_positions_that_are_none_are_left_out_and_counted(read: Read) -> None:
    """Those at 0, 0, those that jump, and those at a height that is none."""
    log = unarmed()
    for number in range(20):
        log.fix(10 + 0.1 * number, 10_000_000 if number == 7 else number, alt_m=1e9 if number == 9 else 5.0)
    log.add("POS", TimeUS=12_000_000)
    recording = read(log)
    assert len(recording.track) == 18
    assert recording.without_position == 1
    assert recording.rejected == {"outside the globe": 1}
    assert "Positions left out because their time or height cannot be right: 1" in recording.notes


def test_two_firmwares_in_one_file_are_named(read: Read) -> None:
    """Types mean other messages in the second log; both are read."""
    log = flight()
    renumbered = {
        name: (kind ^ 1, letters, columns)
        for name, (kind, letters, columns) in DataflashWriter().formats.items()
    }
    other = DataflashWriter(renumbered).add("MSG", TimeUS=1, Message="ArduPlane V4.5.7 (2a3dc4b7)").home(5.0)
    for number in range(10):
        other.fix(5 + 0.1 * number, number)
    log.data += other.data
    log.lines += other.lines
    recording = read(log)
    assert len(recording.track) == 50
    assert "The log is of more than one firmware: ArduCopter V4.6.0, ArduPlane V4.5.7" in recording.notes


@pytest.mark.parametrize(
    ("message", "parameters", "expected"),
    [
        ("ArduCopter V4.6.0 (abcdef01)", {}, ("multicopter", True)),
        ("ArduCopter V4.6.0 (abcdef01)", {"FRAME_CLASS": 6}, ("helicopter", False)),
        ("ArduCopter V4.6.0 (abcdef01)", {"FRAME_CLASS": 3}, ("octocopter", True)),
        ("ArduPlane V4.5.7 (2a3dc4b7)", {}, ("fixed wing", False)),
        ("ArduPlane V4.5.7 (2a3dc4b7)", {"Q_ENABLE": 1}, ("VTOL", False)),
        ("ArduRover V4.5.7 (2a3dc4b7)", {}, ("rover", False)),
        ("ArduSub V4.1.0 (2a3dc4b7)", {}, ("submarine", False)),
        ("Calibrating barometer", {}, (None, None)),
    ],
)
def test_the_kind_of_vehicle(
    read: Read, message: str, parameters: dict[str, float], expected: tuple[str | None, bool | None]
) -> None:
    """By the firmware's name, and the frame that it is set to."""
    log = DataflashWriter().add("MSG", Message=message).home(1.0)
    for name, value in parameters.items():
        log.parameter(name, value)
    recording = read(log.fix(10.0).fix(10.1, 1))
    assert (recording.vehicle_type, recording.is_multicopter) == expected
    assert recording.vehicle is None
    assert recording.vehicles == ()


def test_standard_input_and_packed_logs_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same fixes come out of a pipe, and of a file packed with gzip."""
    data = bytes(flight().data)
    packed = tmp_path / "flight.bin.gz"
    packed.write_bytes(gzip.compress(data))
    assert len(read_log(packed).track) == 40
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(data)))
    assert len(read_log("-").track) == 40


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (fmt(72, 31, "POS", "QLLfff", "TimeUS,Lat,Lng,Alt,A,B"), "is a DataFlash log without any position"),
        (
            b"\xa3\x95\x20" + bytes(30),
            "without any description of its rec",
        ),
        (
            fmt(16, 46, "GPS", "QBffLLfffff", "GPSTime,Fix,EPH,EPV,Lat,Lon,Alt,VelN,VelE,VelD,Cog"),
            "is a log of PX4's old logger (.px4log), which is not read; name a log of ArduPilot, or one",
        ),
        (
            bytes(unarmed().receiver(10, Status=1, Lat=0, Lng=0).data),
            "has no usable position: 1 empty record;",
        ),
        (bytes(unarmed().receiver(10, Status=1).data), "has no usable position: 1 rejected (no 3D fix)"),
        (unarmed().text, "is a DataFlash log without any position"),
    ],
    ids=["only-fmt", "no-fmt", "px4log", "empty-position", "no-fix", "text"],
)
def test_a_log_without_a_flight_is_refused_in_one_line(tmp_path: Path, data: bytes, message: str) -> None:
    """The line names the file and what is the matter."""
    path = tmp_path / "some.bin"
    path.write_bytes(data)
    with pytest.raises(LogError) as error:
        read_log(path)
    assert str(error.value).startswith(f"{path} ")
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_a_vehicle_that_the_log_is_not_of_is_refused(tmp_path: Path) -> None:
    """``--vehicle`` is held against SYSID_THISMAV."""
    path = tmp_path / "flight.bin"
    path.write_bytes(flight().data)
    assert len(read_log(path, vehicle=VehicleId(7)).track) == 40
    with pytest.raises(LogError, match="has positions of vehicle 7:1 only, not 3"):
        read_log(path, vehicle=VehicleId(3))
