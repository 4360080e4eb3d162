"""Formats chosen by suffix: what is saved loads back, and what cannot be read is told."""

import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree as Xml

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flight_replay.exceptions import FlightReplayError, MissionError
from flight_replay.logs.flights import select
from flight_replay.logs.read_log import read_log
from flight_replay.logs.sample import sample_log
from flight_replay.mission import formats
from flight_replay.mission.items import Mission, MissionItem
from tests.helpers.format_examples import HOME, MISSION, assert_same, recorded_track


@pytest.mark.parametrize("suffix", formats.LOADED_SUFFIXES)
def test_what_is_saved_loads_back(tmp_path: Path, suffix: str) -> None:
    """Home, splines, holds, speed changes and every frame survive."""
    path = tmp_path / f"mission{suffix.upper()}"
    formats.save(path, MISSION)
    loaded = formats.load_mission(path)
    assert_same(MISSION, loaded)
    assert loaded.home == HOME


numbers = st.floats(-1e5, 1e5)


items = st.builds(
    MissionItem,
    st.sampled_from([16, 21, 22, 82, 93, 178, 206]),
    st.sampled_from([0, 2, 3, 10]),
    st.tuples(numbers, numbers, numbers, numbers),
    st.floats(-90, 90),
    st.floats(-180, 180),
    st.floats(-1e4, 1e4),
)


@given(st.lists(items, max_size=5).map(tuple))
def test_any_mission_survives_both_mission_formats(rows: tuple[MissionItem, ...]) -> None:
    """Numbers come back to eight decimals from .waypoints and exactly from .plan."""
    mission = Mission(rows, HOME)
    assert_same(mission, formats.wpl.parse(formats.wpl.text(mission), "a file"))
    assert formats.qgc_plan.parse(formats.qgc_plan.text(mission), "a file") == mission


def test_unknown_suffixes_are_told_with_the_known_ones(tmp_path: Path) -> None:
    """One sentence names the file, its suffix and every suffix that would do."""
    with pytest.raises(FlightReplayError, match=r'a\.doc: .*"\.doc"; use one of \.waypoints, \.plan, \.kml'):
        formats.save("a.doc", MISSION)
    with pytest.raises(FlightReplayError, match=r'a\.kml: .*"\.kml"; use one of \.waypoints, \.plan$'):
        formats.load_mission("a.kml")


def test_files_that_cannot_be_read_are_told(tmp_path: Path) -> None:
    """A missing file and one that is no text are each one sentence."""
    with pytest.raises(MissionError, match="No such file"):
        formats.load_mission(tmp_path / "none.plan")
    (tmp_path / "bytes.plan").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(MissionError, match="is not text"):
        formats.load_mission(tmp_path / "bytes.plan")


def test_a_mission_that_mavlink_cannot_count_is_told(tmp_path: Path) -> None:
    """MISSION_COUNT has 16 bits, and home is one of the items."""
    path = tmp_path / "m.waypoints"
    path.write_text("QGC WPL 110\n" + "1 0 3 16 0 0 0 0 1 1 1 1\n" * 65535)
    with pytest.raises(MissionError, match="has 65535 items, more than the 65534"):
        formats.load_mission(path)


@pytest.mark.parametrize(
    ("suffix", "kind", "counts"),
    [(".kml", "kml", (5, 0, 4)), (".gpx", "gpx", (1, 4, 4))],
)
def test_gpsbabel_reads_kml_and_gpx(
    tmp_path: Path, suffix: str, kind: str, counts: tuple[int, int, int]
) -> None:
    """GPSBabel finds every waypoint, route point and track point; KML's route line is one more track."""
    if shutil.which("gpsbabel") is None:
        pytest.skip("gpsbabel is not installed")
    path, out = tmp_path / f"mission{suffix}", tmp_path / "out.gpx"
    formats.save(path, MISSION, recorded_track())
    command = ["gpsbabel", "-w", "-r", "-t", "-i", kind, "-f", str(path), "-o", "gpx", "-F", str(out)]
    subprocess.run(command, check=True, timeout=20, capture_output=True)
    names = [element.tag.rpartition("}")[2] for element in Xml.parse(out).getroot().iter()]
    lines = len(formats.item_text.route_line(MISSION)[0]) if kind == "kml" else 0
    assert (names.count("wpt"), names.count("rtept"), names.count("trkpt") - lines) == counts


@pytest.mark.parametrize("suffix", [".kml", ".gpx"])
def test_tracks_with_the_time_of_day_are_read_back_with_it(tmp_path: Path, suffix: str) -> None:
    """KML has them in a gx:Track, GPX at each point; a replay of the file is one of the flight."""
    recording = read_log(sample_log())
    track = select(recording.track, from_s=60.0, to_s=90.0)
    formats.save(tmp_path / f"a{suffix}", MISSION, track, recording.utc_s_of(track))
    back = read_log(tmp_path / f"a{suffix}")
    assert back.start_utc_s == pytest.approx((recording.start_utc_s or 0.0) + 60.0, abs=1.0)
    assert np.diff(back.track.time_s) == pytest.approx(np.diff(track.time_s), abs=0.0015)
    assert back.track.lat_deg == pytest.approx(track.lat_deg, abs=1e-8)
