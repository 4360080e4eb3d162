"""KML for Google Earth: pins, lines and altitudes."""

from xml.etree import ElementTree as Xml

from flight_replay.mission import formats
from flight_replay.mission.items import Mission
from tests.helpers.format_examples import MISSION, recorded_track

KML = "{http://www.opengis.net/kml/2.2}"


def test_kml_pins_every_waypoint_above_the_sea_and_draws_route_and_track() -> None:
    """Heights are home's plus the item's; a fix whose height is unknown does not break the line."""
    root = Xml.fromstring(formats.kml.text(MISSION, recorded_track()))
    pins = {pin.findtext(f"{KML}name"): pin for pin in root.iter(f"{KML}Placemark")}
    assert list(pins) == ["Home", "1", "3", "4", "5", "Route", "Recorded track"]
    point = pins["3"].find(f"{KML}Point")
    assert point is not None
    assert point.findtext(f"{KML}altitudeMode") == "absolute"
    assert point.findtext(f"{KML}coordinates") == "8.54579412,47.39794213,519.750"
    assert pins["3"].findtext(f"{KML}description") == "spline waypoint, 31.5 m above home, hold 2 s"
    values = {d.get("name"): d.findtext(f"{KML}value") for d in pins["3"].iter(f"{KML}Data")}
    assert (values["command"], values["hold_s"], values["speed_m_s"]) == ("82", "2.0", "4.25")
    lines = [line.split() for line in (e.text or "" for e in root.iter(f"{KML}coordinates")) if "\n" in line]
    curve, recorded = lines
    assert len(curve) > 10
    assert curve[0] == "8.54569412,47.39784213,518.250"
    assert curve[-1] == "8.54600000,47.39800000,520.000"
    assert len(recorded) == 4
    assert recorded[2] == "8.54570000,47.39790000,0.000"


def test_kml_without_home_keeps_heights_above_ground() -> None:
    """Nothing tells the height above the sea, so pins stand above ground, and the line too."""
    root = Xml.fromstring(formats.kml.text(Mission(MISSION.items)))
    modes = [mode.text for mode in root.iter(f"{KML}altitudeMode")]
    assert modes == ["relativeToGround"] * 3 + ["absolute", "relativeToGround"]
    assert "Recorded track" not in formats.kml.text(Mission(()))
