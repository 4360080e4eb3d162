"""GPX 1.1: a route, a track, and elevations."""

from dataclasses import replace
from xml.etree import ElementTree as Xml

from flight_replay.mission import formats
from flight_replay.mission.items import Mission, waypoint
from tests.helpers.format_examples import HOME, MISSION, recorded_track

GPX = "{http://www.topografix.com/GPX/1/1}"


def test_gpx_holds_home_the_route_and_one_segment_a_boot() -> None:
    """Home is a waypoint, the mission a route, the track a track; unknown elevations are left out."""
    root = Xml.fromstring(formats.gpx.text(MISSION, recorded_track()))
    assert [point.findtext(f"{GPX}name") for point in root.iter(f"{GPX}wpt")] == ["Home"]
    assert [point.findtext(f"{GPX}name") for point in root.iter(f"{GPX}rtept")] == ["1", "3", "4", "5"]
    assert next(point.findtext(f"{GPX}ele") for point in root.iter(f"{GPX}rtept")) == "518.250"
    assert [len(segment) for segment in root.iter(f"{GPX}trkseg")] == [2, 2]
    assert [point.findtext(f"{GPX}ele") for point in root.iter(f"{GPX}trkpt")] == [
        "488.000",
        "489.000",
        None,
        "488.000",
    ]


def test_gpx_without_a_height_above_the_sea_has_no_elevations() -> None:
    """Neither of home nor of waypoints; heights above home are in the extensions."""
    mission = Mission(MISSION.items[:3], replace(HOME, alt_amsl_m=None))
    assert "<ele>" not in formats.gpx.text(mission)
    assert "<replay:alt_m>31.5</replay:alt_m>" in formats.gpx.text(mission)


def test_gpx_longitudes_end_below_180() -> None:
    """GPX 1.1 allows -180 but not 180."""
    root = Xml.fromstring(formats.gpx.text(Mission((waypoint(0.0, 180.0, 1.0),))))
    assert [point.get("lon") for point in root.iter(f"{GPX}rtept")] == ["-180.00000000"]
