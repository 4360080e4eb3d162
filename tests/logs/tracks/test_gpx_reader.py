"""GPX: times, segments, heights, and what other programs make of them."""

import codecs
import gzip
import re

import numpy as np
import pytest

from flight_replay.exceptions import LogError
from flight_replay.logs.flights import find_flights
from flight_replay.logs.track import UNTIMED_SPEED_M_S, Armed
from flight_replay.mission import formats
from tests.helpers.format_examples import MISSION, recorded_track
from tests.helpers.track_files import START_S, gpx, gpx_of, kind_of_bytes, moving, read_bytes


def test_a_gpx_track_has_times_places_and_heights_above_where_it_took_off() -> None:
    """Heights in the file are above the sea; the clock counts from the first point."""
    recording = read_bytes(gpx(moving()))
    track = recording.track
    assert (recording.format, recording.notes, track.timed) == ("gpx", (), True)
    assert recording.start_utc_s == START_S
    assert track.time_s.tolist() == list(range(60))
    assert track.amsl_m[[0, -1]].tolist() == [400.0, 449.0]
    assert track.alt_m[0] == pytest.approx(0.0, abs=1.0)
    assert np.isnan(track.heading_deg).all()
    assert (track.armed == Armed.UNKNOWN).all()


def test_velocities_come_from_the_positions_and_show_the_flight() -> None:
    """5 m/s north and 1 m/s up, after 10 s of standing still."""
    track = read_bytes(gpx(moving())).track
    assert track.north_m_s[20:50] == pytest.approx(5.0, abs=0.01)
    assert track.up_m_s[20:50] == pytest.approx(1.0, abs=0.01)
    assert track.north_m_s[:9] == pytest.approx(0.0, abs=0.01)
    (flight,) = find_flights(track)
    assert (flight.first, flight.last) == (10, 59)


V1_0 = "<course>{course}</course><speed>{speed}</speed>"
V1_1 = (
    "<extensions><g:TrackPointExtension><g:speed>{speed}</g:speed><g:course>{course}</g:course>"
    "</g:TrackPointExtension></extensions>"
)


def with_speeds(elements: str, speed: float = 5.2, course: float = 3.0) -> bytes:
    """A track whose points also tell a speed and a course, as long as they move."""
    said = [elements.format(speed=speed if n >= 10 else 0, course=course).encode() for n in range(60)]
    begin, *points = gpx(moving()).split(b"</trkpt>")
    page = begin + b"".join(each + b"</trkpt>" + point for each, point in zip(said, points, strict=True))
    return page.replace(b"<gpx ", b'<gpx xmlns:g="g" ', 1)


@pytest.mark.parametrize("elements", [V1_0, V1_1], ids=["1.0", "1.1"])
def test_speeds_and_courses_are_read(elements: str) -> None:
    """They are sharper than what the positions tell; vertical velocities come from these."""
    track = read_bytes(with_speeds(elements)).track
    assert track.north_m_s[10:] == pytest.approx(5.2 * np.cos(np.radians(3.0)))
    assert track.east_m_s[10:] == pytest.approx(5.2 * np.sin(np.radians(3.0)))
    assert track.north_m_s[:10].tolist() == [0.0] * 10
    assert track.up_m_s[20:50] == pytest.approx(1.0, abs=0.01)
    assert np.isnan(track.heading_deg).all()


@pytest.mark.parametrize(
    ("elements", "speed", "course"),
    [
        (V1_0, 18.0, 0.0),
        (V1_0, 5.0, 90.0),
        (V1_0, 1e9, 0.0),
        ("<extensions><speed>{speed}</speed><course>{course}</course></extensions>", 5.2, 0.0),
        ("<speed>{speed}</speed>", 5.2, 0.0),
    ],
    ids=["km/h", "other course", "nonsense", "unknown unit", "no course"],
)
def test_speeds_that_are_not_those_of_the_positions_do_not_count(
    elements: str, speed: float, course: float
) -> None:
    """Nor those of extensions whose unit nobody knows."""
    track = read_bytes(with_speeds(elements, speed, course)).track
    assert track.north_m_s[20:50] == pytest.approx(5.0, abs=0.01)
    assert track.east_m_s == pytest.approx(0.0, abs=0.01)


def test_speeds_do_not_make_jumps_plausible() -> None:
    """A point 3 km aside stays an outlier, whatever speed it tells."""
    points = moving()
    points[30] = (30.0, 47.03, 8.0, 400.0)
    said = gpx(points).replace(b"</trkpt>", b"<speed>59</speed><course>0</course></trkpt>")
    assert read_bytes(said).rejected == {"impossible jump": 1}


def test_a_track_without_elevations_shows_its_flight() -> None:
    """Its heights and climbs are unknown, but it moves."""
    track = read_bytes(re.sub(rb"<ele>[^<]*</ele>", b"", gpx(moving()))).track
    assert np.isnan(track.up_m_s).all()
    (flight,) = find_flights(track)
    assert (flight.first, flight.last) == (10, 59)


def test_points_that_share_a_second_are_spread_over_it() -> None:
    """As programs write that round the times of eight points a second down."""
    points = [(float(n // 8), lat, lon, height) for n, (_, lat, lon, height) in enumerate(moving(80))]
    assert read_bytes(gpx(points)).track.time_s == pytest.approx(np.arange(80) / 8)


def test_a_segment_is_a_new_boot_only_behind_a_gap_in_time() -> None:
    """Receivers begin one whenever they lost the satellites for a moment."""
    points = moving()
    close = read_bytes(gpx(points[:30], points[32:])).track
    assert close.boot.tolist() == [0] * 58
    late = read_bytes(gpx(points[:30], moving(start_s=60.0)[30:])).track
    assert late.boot.tolist() == [0] * 30 + [1] * 30


def test_heights_that_count_from_the_air_are_told_for_a_segment_behind_a_gap_too() -> None:
    """Home is not known there: it is taken to be where the segment begins."""
    recording = read_bytes(gpx(moving(90)[:40], moving(90)[60:]))
    assert [flight.first for flight in find_flights(recording.track)] == [10, 40]
    assert recording.track.alt_m[40] == 0.0
    told = "Heights of 1 of its 2 flights count from a first fix that moves: if that was in the air"
    assert recording.notes[0].startswith(told)
    assert recording.notes[0].endswith(", they are too low; raise them with --altitude recorded+M")


def test_of_tracks_at_the_same_time_the_longer_one_is_read() -> None:
    """Two recorders in one file are not mixed; a later track, though first in the file, follows."""
    aside = [(time_s, lat, lon + 0.01, height) for time_s, lat, lon, height in moving(30)]
    recording = read_bytes(gpx_of([[moving(40, start_s=1000.0)], [aside], [moving()]]))
    assert recording.notes == ("Left out: 1 track at the same time as a longer one",)
    assert recording.track.lon_deg.tolist() == [8.0] * 100
    assert (np.diff(recording.track.time_s) > 0).all()
    assert recording.track.boot.tolist() == [0] * 60 + [1] * 40


def test_a_track_that_begins_before_the_last_one_ends_goes_on_where_that_ends() -> None:
    """Whole seconds, or two clocks, let tracks overlap."""
    points = moving()
    recording = read_bytes(gpx_of([[points[:35]], [points[32:]]]))
    assert recording.notes == ()
    assert recording.track.time_s.tolist() == list(range(60))
    assert recording.track.boot.tolist() == [0] * 60


@pytest.mark.parametrize("at", [0, 59])
def test_a_date_that_the_receiver_did_not_know_is_no_part_of_the_flight(at: int) -> None:
    """A point of years before or after is a boot of its own."""
    points = moving()
    points[at] = (1e9 if at else -1e9, *points[at][1:])
    boot = read_bytes(gpx(points)).track.boot
    assert boot.tolist() == ([0] + [1] * 59 if at == 0 else [0] * 59 + [1])


def test_points_without_a_time_among_others_are_left_out() -> None:
    """A file mostly with times counts as timed."""
    points = moving()
    points[5] = (None, *points[5][1:])
    recording = read_bytes(gpx(points))
    assert len(recording.track) == 59
    assert recording.notes == ("Left out: 1 point without a time",)


def test_a_timed_track_is_read_beside_a_longer_one_without_times() -> None:
    """The plan may have more points than what was flown."""
    plan = [(None, 47.1, 8.1 + n * 1e-5, 400.0) for n in range(150)]
    recording = read_bytes(gpx_of([[plan], [moving()]]))
    assert recording.track.timed
    assert len(recording.track) == 60
    assert recording.notes[0] == "Left out: 150 points without a time"


def test_a_track_without_times_is_flown_at_one_speed_as_one_flight() -> None:
    """Its clock only keeps the order, and it says so."""
    recording = read_bytes(gpx(moving(timed=False)))
    track = recording.track
    assert not track.timed
    assert not track.select(slice(3)).timed
    assert recording.notes == ("It has no times: only its line can be replayed",)
    assert recording.start_utc_s is None
    assert track.time_s[-1] == pytest.approx(track.length_m / UNTIMED_SPEED_M_S)
    assert len(find_flights(track)) == 1
    assert track.alt_m[-1] == pytest.approx(49.0)


def test_without_times_tracks_are_flights_and_joined_segments_are_one() -> None:
    """A segment that begins 50 m away is another flight."""
    points = moving(timed=False)
    assert len(find_flights(read_bytes(gpx_of([[points[:30]], [points[30:]]])).track)) == 2
    assert len(find_flights(read_bytes(gpx(points[:30], points[31:])).track)) == 1
    assert len(find_flights(read_bytes(gpx(points[:30], points[45:])).track)) == 2


def test_implausible_places_and_heights_are_left_out() -> None:
    """As converters of logs write them: 0, 0, jumps, and 19 km up; with and without times."""
    for timed in (True, False):
        points = moving(timed=timed)
        points[20] = (points[20][0], -72.0, 1.0, 400.0)
        points[30] = (points[30][0], 0.0, 0.0, 400.0)
        points[40] = (*points[40][:3], 19_450.0)
        points[50] = (*points[50][:3], 1e300)
        recording = read_bytes(gpx(points))
        assert recording.rejected == {"impossible jump": 1}
        assert recording.without_position == 1
        assert np.flatnonzero(~np.isfinite(recording.track.alt_m)).tolist() == [38, 48]
        assert np.ptp(recording.track.lat_deg) < 0.01


def test_what_this_program_saves_is_read_again() -> None:
    """Without times, as a vehicle's clock has no date."""
    recording = read_bytes(formats.gpx.text(MISSION, recorded_track()).encode())
    assert recording.track.lat_deg.tolist() == recorded_track().lat_deg.tolist()
    assert not recording.track.timed


def test_a_route_is_taken_for_a_track_where_there_is_none() -> None:
    """As of a mission that was saved without one."""
    recording = read_bytes(formats.gpx.text(MISSION).encode())
    assert recording.notes[0] == "It has no track, but a route, which is taken for one"
    assert len(recording.track) == 4


@pytest.mark.parametrize(
    "change",
    [
        gzip.compress,
        lambda data: codecs.BOM_UTF8 + b"\r\n " + data,
        lambda data: b"\n\n" + data,
        lambda data: data.replace(b"<gpx", b"<!-- made\nby hand --><gpx"),
        lambda data: data.decode().replace("?>", ' encoding="UTF-16"?>').encode("utf-16"),
        lambda data: data.decode().replace("?>", ' encoding="UTF-16"?>').encode("utf-16-le"),
        lambda data: data.replace(b"?>", b' encoding="ISO-8859-1"?><!-- \xe4 -->'),
        lambda data: data.replace(b"<trkpt", b"<g:trkpt").replace(b"</trkpt", b"</g:trkpt"),
    ],
)
def test_a_gpx_file_may_be_packed_and_encoded_in_many_ways(change: object) -> None:
    """Its contents tell, and what is before them does not matter."""
    assert callable(change)
    data = change(gpx(moving()))
    assert len(read_bytes(data).track) == 60


def test_a_file_that_ends_early_is_read_up_to_there() -> None:
    """Recorders lose power."""
    data = gpx(moving())
    recording = read_bytes(data[: len(data) // 2])
    assert 25 < len(recording.track) < 35
    assert recording.notes[0].startswith("It is read up to a fault in its XML: ")


def test_times_may_have_fractions_and_zones() -> None:
    """ISO 8601 as it is met."""
    points = [(n / 4, 47.0 + n * 1e-5, 8.0, 400.0) for n in range(20)]
    track = read_bytes(gpx(points, digits=3).replace(b"Z</time>", b"+02:00</time>"))
    assert track.track.time_s == pytest.approx(np.arange(20) / 4)
    assert track.start_utc_s == START_S - 7200


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b'<gpx version="1.1"></gpx>', "made has no usable position: it holds no track; name another log"),
        (b'<gpx><trk><trkseg><trkpt lat="x"/></trkseg></trk></gpx>', "outside the globe"),
        (b"<!DOCTYPE gpx [<!ENTITY a 'a'>]><gpx>&a;</gpx>", "declares a document type"),
        (b"<!DOCTYPE gpx SYSTEM 'http://127.0.0.1/x'><gpx/>", "declares a document type"),
        (b"<gpx>" + b"<a>" * 200, "elements more than 100 deep"),
        (b"<gpx><!--" + b"x" * (3 << 20), "a tag or a comment of more than 1 MB"),
        (b"<gpx a='" + b"x" * (3 << 20), "a tag or a comment of more than 1 MB"),
        (b"<gpx>" + b"<a/>" * (1 << 20), "has no point of a track in 200000 elements"),
        (b"<gpx>" + b"<a>laugh</a>" * 100_000 + b"x" * (9 << 20), "has no point of a track in 8 MB"),
        (b"<gpx>" + b"".join(b"<a%d/>" % n for n in range(20_000)), "more than 10000 kinds of elements"),
    ],
)
def test_a_file_that_is_no_track_is_refused_in_one_line(data: bytes, message: str) -> None:
    """Whatever it was made for."""
    assert kind_of_bytes(data) == "gpx"
    with pytest.raises(LogError) as caught:
        read_bytes(data)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_entities_are_not_expanded() -> None:
    """A billion laughs end before the first."""
    laughs = "".join(f'<!ENTITY l{n} "{f"&l{n - 1};" * 10}">' for n in range(1, 10))
    data = f'<?xml version="1.0"?><!DOCTYPE gpx [<!ENTITY l0 "lol">{laughs}]><gpx>&l9;</gpx>'.encode()
    with pytest.raises(LogError, match="declares a document type"):
        read_bytes(data)
