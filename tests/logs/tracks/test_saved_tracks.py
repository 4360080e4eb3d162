"""What ``--save`` writes as CSV and GeoJSON is the same track when it is read."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats
from flight_replay.logs.read_log import read_log
from flight_replay.logs.track import COLUMNS, Armed, Track, track_from_columns
from flight_replay.mission import formats
from flight_replay.mission.items import Home
from tests.helpers.format_examples import MISSION
from tests.helpers.paths import SAMPLE
from tests.helpers.track_files import kind_of_bytes, read_bytes

WRITERS = {"csv": formats.csv_table.text, "geojson": formats.geojson.text}
PRECISION = {"time_s": 1e-6, "lat_deg": 1e-8, "lon_deg": 1e-8}


def full_track(fixes: int = 40) -> Track:
    """A track with all there may be, across the antimeridian, in two boots."""
    n = np.arange(fixes)
    at: Floats = np.arange(fixes, dtype=np.float64)
    return track_from_columns(
        np.asarray(100.123456 + at / 7, np.float64),
        np.asarray(-17.0 + at * 1e-5, np.float64),
        np.asarray((179.9999 + at * 1e-5 + 180.0) % 360.0 - 180.0, np.float64),
        np.asarray(at * 0.5, np.float64),
        amsl_m=np.where(n % 9 == 4, np.nan, 20.0 + n * 0.5),
        velocity_m_s=np.column_stack([np.full(fixes, 7.777), n * 0.01, np.full(fixes, 3.5)]),
        heading_deg=np.where(n % 5 == 0, np.nan, n * 9.0 % 360.0),
        boot=(n // 25).astype(np.int32),
        armed=np.where(n < 5, Armed.NO, Armed.YES).astype(np.int8),
    )


def assert_same_track(track: Track, wanted: Track) -> None:
    """Equal to the last digit that is written."""
    assert track.timed == wanted.timed
    for name in COLUMNS:
        got, expected = getattr(track, name), getattr(wanted, name)
        np.testing.assert_allclose(got, expected, rtol=0, atol=0.6 * PRECISION.get(name, 1e-3), err_msg=name)


@pytest.mark.parametrize("kind", WRITERS)
def test_a_saved_track_is_read_as_it_was(kind: str) -> None:
    """Every column, unknown values too."""
    data = WRITERS[kind](MISSION, full_track()).encode()
    assert kind_of_bytes(data) == kind
    assert_same_track(read_bytes(data).track, full_track())


@pytest.mark.parametrize("kind", WRITERS)
def test_a_telemetry_log_is_read_as_it_was(kind: str) -> None:
    """The sample flight, all of it, and when it was."""
    recording = read_log(SAMPLE)
    track, start_utc_s = recording.track, recording.start_utc_s
    again = read_bytes(WRITERS[kind](MISSION, track, start_utc_s).encode())
    assert_same_track(again.track, track)
    assert again.start_utc_s == pytest.approx(start_utc_s, abs=1e-3)


@pytest.mark.parametrize("kind", WRITERS)
@pytest.mark.parametrize("start_utc_s", [None, 0.0, 1.7e9 + 0.25])
def test_a_flight_without_a_date_stays_one(kind: str, start_utc_s: float | None) -> None:
    """Where the log did not tell the time of day; 1970 is a date."""
    again = read_bytes(WRITERS[kind](MISSION, full_track(), start_utc_s).encode())
    assert again.start_utc_s == start_utc_s


def test_a_date_that_is_none_is_none() -> None:
    """Somebody changed it."""
    data = formats.geojson.text(MISSION, full_track(), 1.7e9).replace("2023-11-14T", "yesterday ")
    assert read_bytes(data.encode()).start_utc_s is None


@pytest.mark.parametrize("kind", WRITERS)
def test_a_track_without_times_stays_one(kind: str) -> None:
    """No times are written for it."""
    track = replace(full_track(), timed=False, armed=np.full(40, Armed.YES, np.int8))
    again = read_bytes(WRITERS[kind](MISSION, track).encode()).track
    assert not again.timed
    assert again.lat_deg == pytest.approx(track.lat_deg, abs=1e-8)
    assert again.boot.tolist() == track.boot.tolist()


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
@pytest.mark.parametrize("kind", WRITERS)
def test_spreadsheets_may_change_the_encoding_and_the_line_ends(kind: str, encoding: str) -> None:
    """Excel writes CRLF, and a byte order mark."""
    data = WRITERS[kind](MISSION, full_track()).replace("\n", "\r\n").encode(encoding)
    assert_same_track(read_bytes(data).track, full_track())


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_spreadsheets_may_change_the_delimiter_and_the_decimal_point(delimiter: str) -> None:
    """As those do in whose language numbers have a comma."""
    data = formats.csv_table.text(MISSION, full_track()).replace(",", delimiter).replace(".", ",").encode()
    assert kind_of_bytes(data) == "csv"
    assert_same_track(read_bytes(data).track, full_track())


def test_the_columns_of_a_table_may_be_moved_and_fewer() -> None:
    """They are found by their names."""
    data = b"kind,lon_deg,time_s,lat_deg\ntrack,8,1.5,47\nitem,1,1,1\n\ntrack,8.00001,2.5,47\n"
    track = read_bytes(data).track
    assert track.time_s.tolist() == [1.5, 2.5]
    assert track.lat_deg.tolist() == [47.0, 47.0]
    assert track.east_m_s[0] == pytest.approx(0.76, abs=0.01)


def test_a_nul_spoils_its_cell_alone() -> None:
    """Python 3.10's own reader of tables stops at one, or fails."""
    header, *rows = formats.csv_table.text(MISSION, full_track()).encode().splitlines(keepends=True)
    rows[7] = b"\0" + rows[7]
    assert (
        len(
            read_bytes(
                header.rstrip() + b",no\0te\n" + b"".join(each.rstrip() + b",\n" for each in rows)
            ).track
        )
        == 39
    )


SEA_LEVEL_WRITERS = {"gpx": formats.gpx.text, "kml": formats.kml.text}


def in_the_air() -> Track:
    """A part of a flight that begins 12 m above home."""
    track = full_track()
    alt_m: Floats = np.asarray(12.0 + 0.5 * np.arange(len(track)), np.float64)
    return replace(track, alt_m=alt_m, amsl_m=488.25 + alt_m, boot=np.zeros(len(track), np.int32))


@pytest.mark.parametrize("kind", SEA_LEVEL_WRITERS)
@pytest.mark.parametrize("start_utc_s", [None, 1.7e9])
def test_heights_above_the_sea_of_a_part_are_above_the_home_it_was_saved_with(
    kind: str, start_utc_s: float | None
) -> None:
    """What began in the air is not flown lower by as much."""
    again = read_bytes(SEA_LEVEL_WRITERS[kind](MISSION, in_the_air(), start_utc_s).encode())
    assert again.track.alt_m == pytest.approx(in_the_air().alt_m, abs=2e-3)
    assert not [note for note in again.notes if "too low" in note]


@pytest.mark.parametrize("kind", SEA_LEVEL_WRITERS)
@pytest.mark.parametrize("ground_m", [None, 0.0])
def test_a_home_of_which_no_height_was_known_does_not_count(kind: str, ground_m: float | None) -> None:
    """Before home is set autopilots send 0 for the height that it has."""
    mission = MISSION.with_home(Home(-17.0, 179.9, ground_m))
    again = read_bytes(SEA_LEVEL_WRITERS[kind](mission, in_the_air(), 1.7e9).encode()).track
    assert again.alt_m == pytest.approx(in_the_air().alt_m - 12.0, abs=2e-3)


@pytest.mark.parametrize("kind", SEA_LEVEL_WRITERS)
def test_a_home_in_the_file_of_another_program_does_not_count(kind: str) -> None:
    """It may be where somebody lives. A track that begins in motion then says what its heights count from."""
    page = SEA_LEVEL_WRITERS[kind](MISSION, in_the_air(), 1.7e9)
    theirs = page.replace("Recorded track", "Track").replace('creator="flight-replay"', 'creator="else"')
    again = read_bytes(theirs.encode())
    assert again.track.alt_m == pytest.approx(in_the_air().alt_m - 12.0, abs=2e-3)
    assert again.notes[-1].startswith("Its heights count from a first fix that moves: if")
