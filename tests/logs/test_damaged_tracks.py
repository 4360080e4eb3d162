"""Damaged ULogs and tracks: one clear error or a right answer; no wild position, nothing printed, no hang."""

import io
import time

import numpy as np
import pytest

from flight_replay.exceptions import LogError
from flight_replay.geometry.geodesy import distance_m
from flight_replay.logs.byte_source import OpenLog
from flight_replay.logs.flights import find_flights
from flight_replay.logs.log_formats import FORMATS
from flight_replay.logs.recording import Recording
from flight_replay.logs.track import track_from_columns
from flight_replay.mission import formats
from tests.helpers.format_examples import MISSION
from tests.helpers.mutations import ALL_MUTATIONS, mutated
from tests.helpers.track_files import gpx, kml, kml_line, kml_points, kml_track, kmz, moving
from tests.logs.tracks.test_dji_csv import airdata
from tests.logs.ulog.test_ulog_reader import flight

AROUND_M = 60_000.0
"""Digits that are changed behind the point move a place by less; what is farther off jumps."""
LONGEST_S = 5.0
SAVED = track_from_columns(
    np.arange(60, dtype=float),
    np.asarray(47.0 + np.arange(60) * 4e-5, float),
    np.full(60, 8.0),
    np.arange(60, dtype=float),
    velocity_m_s=np.ones((60, 3)),
)
ORIGINALS = {
    "ulog": [bytes(log.data) for log in (flight(), flight(with_global=False), flight().sync())],
    "gpx": [
        gpx(moving()),
        gpx(moving(30), moving(start_s=99.0)),
        gpx(moving(timed=False)),
    ],
    "kml": [kml(kml_track(moving())), kml(kml_points(moving()), kml_line(moving())), kml(kml_line(moving()))],
    "kmz": [kmz(kml(kml_track(moving())))],
    "csv": [formats.csv_table.text(MISSION, SAVED).encode()],
    "geojson": [formats.geojson.text(MISSION, SAVED).encode()],
    "airdata": [airdata()],
}
USABLE = {"geojson": 0.0, "kmz": 0.05}
"""The least share of damaged files that has a usable rest; the others can be read up to any fault."""


def read_damaged(kind: str, seed: int) -> Recording | None:
    """What is read of a damaged file by the reader of its format; None after one clear error."""
    log_format = next(each for each in FORMATS if each.name == kind)
    log = OpenLog("damaged", io.BytesIO(mutated(ORIGINALS[kind], np.random.default_rng(seed), ALL_MUTATIONS)))
    if not log_format.begins(log.head):
        return None
    try:
        return log_format.read(log, None, None)
    except LogError as error:
        assert str(error).startswith("damaged ")
        assert "\n" not in str(error)
        return None


def check(kind: str, seeds: range, capsys: pytest.CaptureFixture[str]) -> int:
    """Read damaged files; returns how many were usable."""
    usable = 0
    for seed in seeds:
        begin = time.process_time()
        recording = read_damaged(kind, seed)
        assert time.process_time() - begin < LONGEST_S, seed
        if recording is not None:
            usable += 1
            check_recording(recording, seed)
    assert capsys.readouterr().out == ""
    return usable


def check_recording(recording: Recording, seed: int) -> None:
    """Hold a recording against what readers promise."""
    track = recording.track
    assert len(track) > 0
    assert (np.diff(track.time_s) >= 0).all(), seed
    assert np.isfinite(track.time_s).all()
    assert np.isfinite(track.north_east_m()).all()
    assert (np.diff(track.boot) >= 0).all()
    assert set(np.diff(track.boot).tolist()) <= {0, 1}
    find_flights(track)
    apart_m = distance_m(track.lat_deg, track.lon_deg, np.median(track.lat_deg), np.median(track.lon_deg))
    assert np.mean(apart_m > AROUND_M) <= 0.5, seed


@pytest.mark.parametrize("kind", ORIGINALS)
def test_damaged_files_give_a_track_or_one_clear_error(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Some of each format."""
    seeds = range(15 if kind == "ulog" else 60)
    assert check(kind, seeds, capsys) >= len(seeds) * USABLE.get(kind, 0.2)


def test_a_ulog_whose_damage_sends_pyulog_back_and_back_ends(capsys: pytest.CaptureFixture[str]) -> None:
    """A message that claims to be longer than the file; two million steps in 80 kB."""
    check("ulog", range(2_644, 2_645), capsys)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ORIGINALS)
def test_two_thousand_damaged_files_give_a_track_or_one_clear_error(
    kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """As above."""
    assert check(kind, range(1_000, 3_000), capsys) > 2_000 * USABLE.get(kind, 0.2)
