"""ULog: which positions, velocities, headings, heights and arming are read."""

import gzip
import math
import struct

import numpy as np
import pytest

from flight_replay.exceptions import LogError
from flight_replay.logs.flights import find_flights
from flight_replay.logs.track import Armed
from flight_replay.logs.ulog.ulog_positions import from_reference
from tests.helpers.track_files import kind_of_bytes, read_bytes
from tests.helpers.ulog_writer import (
    GLOBAL,
    HOME,
    INFO,
    LANDED,
    LOCAL,
    NEW_GPS,
    OLD_GPS,
    STATUS,
    UlogWriter,
)


def flight(*, with_global: bool = True, with_home: bool = True, landed: bool = False) -> UlogWriter:
    """Forty seconds: armed from 5 to 35 s, northwards at 5 m/s, 30 m up, nose to the east."""
    formats = {**(GLOBAL if with_global else {}), **LOCAL, **STATUS, **LANDED, **(HOME if with_home else {})}
    log = UlogWriter(formats, INFO)
    if with_home:
        log.sample("home_position", 1.0, 47.0, 8.0, 400.0, 1)
    for n in range(400):
        time_s = 1.0 + n / 10
        x_m = 5.0 * n / 10
        local = (47.0, 8.0, 400.0, x_m, 0.0, -30.0, 5.0, 0.0, 0.5, math.pi / 2, 1, 1)
        log.sample("vehicle_local_position", time_s, *local)
        if with_global and n % 2 == 0:
            lat, lon = from_reference(*(np.array([value]) for value in (47.0, 8.0, x_m, 0.0)))
            log.sample("vehicle_global_position", time_s, float(lat[0]), float(lon[0]), 430.0)
        if n % 10 == 0:
            log.sample("vehicle_status", time_s, 2 if 5 <= time_s < 35 else 1, 2)
            log.sample("vehicle_land_detected", time_s, landed or not 6 <= time_s < 34)
    return log


def test_a_ulog_gives_position_velocity_heading_height_and_arming() -> None:
    """From the topics of the estimator."""
    recording = read_bytes(bytes(flight().data))
    track = recording.track
    assert (recording.format, recording.vehicle_type, recording.is_multicopter) == (
        "ulog",
        "quadcopter",
        True,
    )
    assert (recording.firmware, recording.notes) == ("PX4 v1.15.4", ())
    assert len(track) == 200
    assert track.time_s[0] == 1.0
    assert track.north_east_m()[100] == pytest.approx([100.0, 0.0], abs=0.2)
    assert (track.north_m_s[9], track.up_m_s[9], track.heading_deg[9]) == pytest.approx((5.0, -0.5, 90.0))
    assert (track.alt_m[0], track.amsl_m[0]) == pytest.approx((30.0, 430.0))
    (found,) = find_flights(track)
    assert (found.start_s, found.end_s) == pytest.approx((4.0, 33.8))


def test_a_signalling_nan_is_left_out_without_a_warning() -> None:
    """Damage makes them; numpy warns where it makes a double of one."""
    mark = struct.pack("<f", 1234.5)
    damaged = flight()
    damaged.sample("vehicle_global_position", 42.0, 47.0, 8.0, 1234.5)
    data = bytes(damaged.data).replace(mark, struct.pack("<I", 0x7F800001))
    assert len(read_bytes(data).track) == 200


def test_without_global_positions_the_local_ones_around_their_reference_are_read() -> None:
    """The same places, twice as often."""
    both = read_bytes(bytes(flight().data)).track
    recording = read_bytes(bytes(flight(with_global=False).data))
    assert len(recording.track) == 400
    assert "those of vehicle_local_position" in recording.notes[0]
    assert recording.track.lat_deg[::2] == pytest.approx(both.lat_deg, abs=1e-8)
    assert recording.track.alt_m == pytest.approx(np.full(400, 30.0))


def test_without_a_home_the_ground_is_where_it_was_armed() -> None:
    """At the first armed fix."""
    track = read_bytes(bytes(flight(with_home=False).data)).track
    assert track.alt_m == pytest.approx(np.zeros(200))


def test_an_armed_vehicle_that_stays_on_the_ground_is_told() -> None:
    """By PX4's own detector."""
    assert "never took off" in read_bytes(bytes(flight(landed=True).data)).notes[-1]


@pytest.mark.parametrize("new", [False, True])
def test_without_an_estimate_the_receiver_counts_where_it_has_a_fix(new: bool) -> None:
    """Integers until PX4 1.13, degrees and metres since."""
    log = UlogWriter(NEW_GPS if new else OLD_GPS, INFO)
    for n in range(50):
        fix = 3 if n >= 10 else 2
        if new:
            log.sample("sensor_gps", n / 5, 47.0 + n * 1e-5, 8.0, 400.0 + n, fix)
        else:
            log.sample(
                "vehicle_gps_position",
                n / 5,
                47e7 + n * 100,
                8e7,
                4e5 + n * 1000,
                fix,
                1_772_359_200e6 + n * 2e5,
            )
    recording = read_bytes(bytes(log.data))
    assert recording.rejected == {"no 3D fix": 10}
    assert "those of the GPS receiver" in recording.notes[0]
    assert recording.track.lat_deg[0] == pytest.approx(47.0001)
    assert recording.track.amsl_m[-1] == pytest.approx(449.0)
    assert recording.track.north_m_s[20] == pytest.approx(5.56, abs=0.01)
    assert (recording.track.armed == Armed.UNKNOWN).all()
    assert recording.start_utc_s == (None if new else pytest.approx(1_772_359_202.0))


@pytest.mark.parametrize("fixes", [0, 20])
def test_of_two_receivers_the_one_that_has_the_fixes_is_read(fixes: int) -> None:
    """The first is dead, or was late by most of the flight."""
    log = UlogWriter(NEW_GPS, INFO)
    log.message("A", struct.pack("<BH", 1, len(NEW_GPS)) + b"sensor_gps")
    for n in range(50):
        log.sample("sensor_gps", n / 5, 46.0, 9.0, 0.0, 3 if n >= 50 - fixes else 0)
        second = struct.pack("<QdddB", round(n / 5 * 1e6), 47.0 + n * 1e-5, 8.0, 400.0, 3)
        log.message("D", struct.pack("<H", len(NEW_GPS)) + second)
    recording = read_bytes(bytes(log.data))
    assert recording.rejected == {}
    assert recording.track.lat_deg == pytest.approx(47.0 + np.arange(50) * 1e-5)


def test_a_leftover_of_the_estimator_does_not_hide_the_receiver() -> None:
    """Two seconds of it beside a minute of the receiver's."""
    log = UlogWriter({**GLOBAL, **NEW_GPS})
    for n in range(300):
        if n < 10:
            log.sample("vehicle_global_position", n / 5, 47.0, 8.0, 400.0)
        log.sample("sensor_gps", n / 5, 47.0 + n * 1e-5, 8.0, 400.0, 3)
    assert len(read_bytes(bytes(log.data)).track) == 300


def test_damage_is_told_and_the_rest_is_read() -> None:
    """A hole of zeros, after which a sync message helps to go on."""
    log = flight()
    half = len(log.data) // 2
    data = (
        bytes(log.data[:half])
        + bytes(3_000)
        + b"\x08\x00S\x2f\x73\x13\x20\x25\x0c\xbb\x12"
        + bytes(log.data[half:])
    )
    recording = read_bytes(data)
    assert len(recording.track) > 90
    assert recording.notes[-1] == "Parts of the log are damaged; the rest is read"


def test_long_damage_does_not_take_long() -> None:
    """A file system may leave megabytes of zeros at the end."""
    recording = read_bytes(bytes(flight().data) + bytes(20 << 20))
    assert len(recording.track) == 200


def test_a_log_may_come_packed() -> None:
    """It is kept in memory then."""
    assert len(read_bytes(gzip.compress(bytes(flight().data))).track) == 200


def test_dropouts_are_told() -> None:
    """If they are worth it."""
    log = flight()
    for _ in range(3):
        log.message("O", struct.pack("<H", 700))
    assert read_bytes(bytes(log.data)).notes == ("The logger lost 2.1 s in all",)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"ULog\x01\x12\x35", r"is a ULog that cannot be read \(Invalid file format \(Header too short\)\)"),
        (bytes(UlogWriter({}).data), "is a ULog without any position"),
        (bytes(UlogWriter(STATUS).sample("vehicle_status", 1.0, 2, 2).data), "without any position"),
        (
            bytes(UlogWriter(GLOBAL).sample("vehicle_global_position", 1.0, 0, 0, 0).data),
            "1 empty record",
        ),
        (bytes(UlogWriter({"a": ("b[60000] x",), "b": ("a[60000] x",)}).data), "damaged list of formats"),
        (
            bytes(UlogWriter({}).data[:16]) + b"\x28\x00B" + b"\0" * 8 + b"\xff" * 8 + bytes(24),
            "Unknown incompatible flag set",
        ),
    ],
)
def test_what_cannot_be_read_is_refused_in_one_line(data: bytes, message: str) -> None:
    """With the name of the log and the next step."""
    assert kind_of_bytes(data) == "ulog"
    with pytest.raises(LogError, match=message) as caught:
        read_bytes(data)
    assert "\n" not in str(caught.value)


def test_pyulog_prints_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    """Its words would stand amid ours, and in the JSON object."""
    read_bytes(bytes(flight().data) + b"\x05\x00D\xff\xff123" * 5)
    assert capsys.readouterr().out == ""
