"""KML and KMZ: tracks, timed points, lines, and which of them is the flight."""

import io
import time
import tracemalloc
import zipfile

import numpy as np
import pytest

from flight_replay.exceptions import LogError
from flight_replay.logs.tracks import byte_pieces, xml_events
from flight_replay.mission import formats
from tests.helpers.format_examples import MISSION, recorded_track
from tests.helpers.track_files import (
    START_S,
    kind_of_bytes,
    kml,
    kml_line,
    kml_points,
    kml_track,
    kmz,
    moving,
    read_bytes,
)


@pytest.mark.parametrize("feature", [kml_track(moving()), kml_points(moving())], ids=["track", "points"])
def test_timed_kml_is_a_timed_track(feature: str) -> None:
    """A gx:Track, or a placemark with a time for each point."""
    recording = read_bytes(kml(feature))
    assert (recording.format, recording.start_utc_s, recording.notes) == ("kml", START_S, ())
    assert recording.track.time_s.tolist() == list(range(60))
    assert recording.track.amsl_m[-1] == 449.0
    assert recording.track.north_m_s[30] == pytest.approx(5.0, abs=0.01)


def test_a_line_is_a_track_without_times() -> None:
    """It has an order only."""
    recording = read_bytes(kml(kml_line(moving())))
    assert not recording.track.timed
    assert len(recording.track) == 60
    assert recording.track.alt_m[-1] == pytest.approx(49.0)


def test_a_flight_that_is_written_twice_is_read_once() -> None:
    """As GPSBabel does: points with times, and a line through them, or a track as well."""
    points = moving()
    for features in (
        [kml_points(points), kml_line(points)],
        [kml_line(points), kml_track(points), kml_points(points)],
    ):
        recording = read_bytes(kml(*features))
        assert len(recording.track) == 60
        assert recording.track.timed


def test_photographs_beside_a_line_are_not_the_flight() -> None:
    """What has less than half of the points of another is beside it."""
    assert len(read_bytes(kml(kml_points(moving(5)), kml_line(moving()))).track) == 60


def test_height_modes_say_what_heights_are_above() -> None:
    """The sea, the ground, or nothing at all: then the line lies on the ground."""
    ground = read_bytes(kml(kml_track(moving(), "relativeToGround"))).track
    assert ground.alt_m[-1] == 449.0
    assert np.isnan(ground.amsl_m).all()
    clamped = read_bytes(kml(kml_line(moving(), mode="")))
    assert np.isnan(clamped.track.alt_m).all()
    assert clamped.notes[0] == "Its heights are not read: it says that it lies on the ground"


def test_heights_above_ground_are_flown_as_recorded() -> None:
    """Though nothing is known of the sea."""
    from flight_replay.planning.altitude import altitudes_m

    track = read_bytes(kml(kml_track(moving(), "relativeToGround"))).track
    assert altitudes_m(track, "recorded").tolist() == track.alt_m.tolist()


def test_headings_of_a_track_are_read() -> None:
    """The first of its angles."""
    angles = "".join(f"<gx:angles>{n} 0 0</gx:angles>" for n in range(60))
    data = kml(kml_track(moving()).replace("</gx:Track>", f"{angles}</gx:Track>"))
    assert read_bytes(data).track.heading_deg.tolist() == list(range(60))


def test_lines_that_join_are_one_and_the_longest_counts() -> None:
    """Mission Planner begins a line at every change of mode."""
    points = moving()
    fence = [(None, 47.1, 8.1, 0.0)] * 3
    recording = read_bytes(kml(kml_line(fence), kml_line(points[:20]), kml_line(points[20:])))
    assert len(recording.track) == 60
    assert not recording.track.boot.any()
    assert recording.notes[0] == "The longest of its lines is read, 1 other is left out"


def test_what_this_program_saves_is_read_again() -> None:
    """The recorded track, not the route, however many points that has."""
    recording = read_bytes(formats.kml.text(MISSION, recorded_track()).encode())
    assert recording.track.lat_deg.tolist() == recorded_track().lat_deg.tolist()


def test_a_multitrack_has_segments() -> None:
    """Which are boots only if time passed between them."""
    points = moving()
    inner = "".join(
        kml_track(part).removeprefix("<Placemark>").removesuffix("</Placemark>")
        for part in (points[:20], points[40:])
    )
    track = read_bytes(kml(f"<Placemark><gx:MultiTrack>{inner}</gx:MultiTrack></Placemark>")).track
    assert track.boot.tolist() == [0] * 20 + [1] * 20


def test_heights_of_a_multitrack_are_what_it_says_they_are() -> None:
    """But for a track of it that says otherwise."""
    inner = kml_track(moving()).removeprefix("<Placemark>").removesuffix("</Placemark>")
    bare = inner.replace("<altitudeMode>absolute</altitudeMode>", "")
    mode = "<altitudeMode>{}</altitudeMode>"
    for said, track in (("absolute", bare), ("relativeToGround", inner)):
        data = f"<Placemark><gx:MultiTrack>{mode.format(said)}{track}</gx:MultiTrack></Placemark>"
        recording = read_bytes(kml(data))
        assert recording.track.amsl_m[0] == 400.0
        assert recording.notes == ()


def test_a_long_track_has_all_times_before_its_places(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both are a part of its points."""
    monkeypatch.setattr(xml_events, "_MOST_IDLE_ELEMENTS", 50)
    monkeypatch.setattr(byte_pieces, "_PIECE_LENGTH", 256)
    assert len(read_bytes(kml(kml_track(moving(200)))).track) == 200


def test_a_file_that_ends_within_a_track_is_read_up_to_there() -> None:
    """And says so."""
    data = kml(kml_track(moving()))
    recording = read_bytes(data[: data.index(b"<gx:coord>8.00000000 47.001")])
    assert 20 < len(recording.track) < 40
    assert "fault in its XML" in recording.notes[0]


@pytest.mark.parametrize("others", [(), (("files/a.png", bytes(5_000)), ("b.txt", b"b"))])
def test_a_kmz_holds_a_kml_file(others: tuple[tuple[str, bytes], ...]) -> None:
    """The first one in it, whatever else there is."""
    data = kmz(kml(kml_track(moving())), "DOC.KML", others)
    assert kind_of_bytes(data) == "kmz"
    assert len(read_bytes(data).track) == 60


def test_a_kmz_may_be_written_to_a_pipe() -> None:
    """Then lengths stand behind the files."""

    class Pipe(io.RawIOBase):
        def __init__(self) -> None:
            self.data = b""

        def writable(self) -> bool:
            return True

        def write(self, data: object) -> int:
            self.data += bytes(data)  # type: ignore[call-overload]
            return len(data)  # type: ignore[arg-type]

    pipe = Pipe()
    with zipfile.ZipFile(pipe, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("style.txt", b"x" * 1000)
        archive.writestr("doc.kml", kml(kml_track(moving())))
    assert len(read_bytes(pipe.data).track) == 60


def test_a_zip_without_a_kml_file_is_refused() -> None:
    """With what to do."""
    with pytest.raises(LogError, match="a ZIP archive without a KML file; unpack it, and name the log in it"):
        read_bytes(kmz(b"a log", "flight.tlog"))


@pytest.mark.parametrize("content", [b" ", b"\0", b"<a/>", b"<gx:coord>8 47 0</gx:coord>", b"<!-- laugh -->"])
def test_a_bomb_in_a_kmz_ends_soon(content: bytes) -> None:
    """A hundred times smaller than it could be: it ends after the same few megabytes."""
    bomb = kmz(b"<kml><Placemark><Track>" + content * ((64 << 20) // len(content)))
    assert len(bomb) < 1 << 20
    begin = time.process_time()
    with pytest.raises(LogError):
        read_bytes(bomb)
    assert time.process_time() - begin < 5


def test_a_kmz_of_valid_places_without_end_is_refused_before_it_is_read() -> None:
    """Sixty-four megabytes are unpacked, which takes a tenth of the time of reading them."""
    chance = np.random.default_rng(1)
    piece = kml_line([(None, 47.0, 8.0 + lon, 500.0) for lon in chance.random(5_000)])
    bomb = kmz(kml(piece * ((70 << 20) // len(piece))))
    begin = time.process_time()
    with pytest.raises(LogError, match="unpacks to more than 64 MB; unpack it, and name the KML file in it"):
        read_bytes(bomb)
    assert time.process_time() - begin < 2


def test_files_before_the_kml_file_are_not_unpacked_where_their_length_is_told() -> None:
    """A picture may be larger than any track."""
    data = kmz(kml(kml_track(moving())), others=(("map.png", bytes(70 << 20)),))
    assert len(read_bytes(data).track) == 60


def test_a_line_of_too_many_places_is_refused_while_it_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    """It takes no more memory than as many points."""
    monkeypatch.setattr(xml_events, "MOST_POINTS", 20_000)
    line = b"<kml><Placemark><LineString><coordinates>" + b"8,47 " * 100_000
    with pytest.raises(LogError, match="has more than 20000 points; name a file"):
        read_bytes(line)


def test_a_bomb_in_a_kmz_takes_little_memory() -> None:
    """What was unpacked is not kept."""
    bomb = kmz(b"<kml>" + b" " * (64 << 20))
    tracemalloc.start()
    with pytest.raises(LogError):
        read_bytes(bomb)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 10 << 20
