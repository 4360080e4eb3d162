"""KML for Google Earth: pins, lines and altitudes."""

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as Xml

import numpy as np
import pytest

from flight_replay.logs.read_log import read_log
from flight_replay.mission import formats
from flight_replay.mission.items import Mission
from tests.helpers.format_examples import HOME, MISSION, recorded_track
from tests.helpers.made_replays import figure_of_eight

KML = "{http://www.opengis.net/kml/2.2}"
GX = "{http://www.google.com/kml/ext/2.2}"
START_UTC_S = 1_700_000_000.0


def test_kml_pins_every_waypoint_above_the_sea_and_draws_route_and_track() -> None:
    """Heights are home's plus the item's; a fix whose height is unknown is between its neighbours."""
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
    assert recorded[2] == "8.54570000,47.39790000,488.500"


def test_kml_without_home_keeps_heights_above_ground() -> None:
    """Nothing tells the height above the sea, so pins stand above ground, and the line too."""
    root = Xml.fromstring(formats.kml.text(Mission(MISSION.items)))
    modes = [mode.text for mode in root.iter(f"{KML}altitudeMode")]
    assert modes == ["relativeToGround"] * 3 + ["absolute", "relativeToGround"]
    assert "Recorded track" not in formats.kml.text(Mission(()))


def test_kml_of_a_recording_that_tells_no_height_above_the_sea_invents_none() -> None:
    """All stands above the ground, as if it were level, and what has no height at all lies on it."""
    mission = MISSION.with_home(replace(HOME, alt_amsl_m=None))
    track = replace(recorded_track(), amsl_m=np.full(4, np.nan))
    root = Xml.fromstring(formats.kml.text(mission, track, START_UTC_S, recorded_track()))
    modes = [mode.text for mode in root.iter() if mode.tag.endswith("altitudeMode")]
    assert modes == ["clampToGround", *["relativeToGround"] * 3, "absolute", *["relativeToGround"] * 5]
    bare = replace(track, alt_m=np.full(4, np.nan))
    assert formats.kml.text(Mission(()), bare, START_UTC_S).count("clampToGround") == 2


def test_heights_above_home_are_read_again(tmp_path: Path) -> None:
    """A replay of such a file flies as high as that of the recording."""
    recorded = replace(figure_of_eight(), amsl_m=np.full(len(figure_of_eight()), np.nan))
    formats.save(tmp_path / "a.kml", MISSION.with_home(replace(HOME, alt_amsl_m=None)), recorded, START_UTC_S)
    back = read_log(tmp_path / "a.kml").track
    assert back.alt_m.tolist() == pytest.approx(recorded.alt_m.tolist(), abs=1e-3)
    assert not np.isfinite(back.amsl_m).any()


def test_what_was_flown_plays_beside_the_recording() -> None:
    """Its clock is 0 at the first recorded fix; vehicles report heights above home."""
    flown = replace(recorded_track(), time_s=recorded_track().time_s - 0.4)
    root = Xml.fromstring(formats.kml.text(MISSION, recorded_track(), START_UTC_S, flown))
    tracks = {
        pin.findtext(f"{KML}name"): track
        for pin in root.iter(f"{KML}Placemark")
        if (track := pin.find(f"{GX}Track")) is not None
    }
    recorded, replayed = tracks["Recorded flight"], tracks["Flown by flight-replay"]
    assert recorded.findtext(f"{KML}when") == "2023-11-14T22:13:20.000Z"
    assert [when.text for when in replayed.iter(f"{KML}when")][:2] == [
        "2023-11-14T22:13:19.600Z",
        "2023-11-14T22:13:20.000Z",
    ]
    assert [place.text for place in replayed.iter(f"{GX}coord")][1] == "8.54560000 47.39780000 489.250"
    places = [pin for pin in root.iter(f"{KML}Placemark") if pin.find(f"{KML}LineString") is not None]
    lines = [pin.findtext(f"{KML}name") for pin in places]
    assert lines == ["Route", "Recorded track", "Flown by flight-replay"]


@pytest.mark.parametrize("start_utc_s", [START_UTC_S, None])
def test_what_was_flown_is_not_read_as_the_recording(tmp_path: Path, start_utc_s: float | None) -> None:
    """A replay of the file is one of the recording; without a time of day there are lines only."""
    recorded = figure_of_eight()
    flown = replace(recorded, lat_deg=recorded.lat_deg + 0.001)
    formats.save(tmp_path / "a.kml", MISSION, recorded, start_utc_s, flown)
    back = read_log(tmp_path / "a.kml").track
    assert back.timed == (start_utc_s is not None)
    assert back.lat_deg.tolist() == pytest.approx(recorded.lat_deg.tolist(), abs=1e-8)
    assert "Flown by" in (tmp_path / "a.kml").read_text(encoding="utf-8")
