"""GeoJSON of other programs."""

import json

import pytest

from flight_replay.exceptions import LogError
from tests.helpers.track_files import START_S, kind_of_bytes, moving, read_bytes, utc


def line(count: int = 60) -> dict[str, object]:
    """The geometry of a made flight."""
    return {
        "type": "LineString",
        "coordinates": [[lon, lat, height] for _, lat, lon, height in moving(count)],
    }


def test_any_line_is_a_track_without_times() -> None:
    """A geometry alone, a feature, or the longest line of a collection."""
    short = {"type": "Feature", "properties": None, "geometry": line(5)}
    feature = {"type": "Feature", "properties": {}, "geometry": line()}
    for value in (line(), feature, {"type": "FeatureCollection", "features": [short, feature, None, 3]}):
        recording = read_bytes(json.dumps(value).encode())
        assert len(recording.track) in (60, 65)
        assert not recording.track.timed
        assert recording.track.amsl_m[-1] == 449.0


def test_members_come_in_any_order() -> None:
    """The kind of a geometry may be told behind its many coordinates."""
    value = {"geometry": dict(sorted(line().items())), "properties": {}, "type": "Feature"}
    assert len(read_bytes(json.dumps(value).encode()).track) == 60


@pytest.mark.parametrize("properties", ["coordinateProperties", "coordTimes"])
def test_times_of_togeojson_are_read(properties: str) -> None:
    """Its newer and its older way of writing them."""
    times = [utc(n) for n in range(60)]
    value = (
        {"coordinateProperties": {"times": times}}
        if properties == "coordinateProperties"
        else {properties: times}
    )
    data = json.dumps({"type": "Feature", "properties": value, "geometry": line()}).encode()
    recording = read_bytes(data)
    assert recording.start_utc_s == START_S
    assert recording.track.time_s.tolist() == list(range(60))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b'{"type": "FeatureCollection", "features": []}', "it holds no track"),
        (b'{"type": "FeatureCollection", "features": ', "is not valid JSON"),
        (b'{"type": "Feature", "a": ' + b"[" * 100_000, "is not valid JSON"),
        (b'{"type": "Feature", "a": ' + b"9" * 100_000 + b"}", "is not valid JSON"),
        (
            b'{"type": "LineString", "coordinates": [[1e999, 47], ["8", null], 5, [true]]}',
            "outside the globe",
        ),
    ],
)
def test_what_holds_no_line_is_refused_in_one_line(data: bytes, message: str) -> None:
    """Whatever else it is."""
    assert kind_of_bytes(data) == "geojson"
    with pytest.raises(LogError, match=message):
        read_bytes(data)
