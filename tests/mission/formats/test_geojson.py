"""GeoJSON: a feature for every item, lines cut at the antimeridian."""

import json
from dataclasses import replace

import numpy as np
import pytest

from flight_replay.mission import formats
from flight_replay.mission.items import Mission, waypoint
from tests.helpers.format_examples import HOME, MISSION, recorded_track


def test_geojson_has_a_feature_for_every_item_and_lines_for_route_and_track() -> None:
    """Places are points, other items have no geometry, properties carry what MAVLink says."""
    features = json.loads(formats.geojson.text(MISSION, recorded_track()))["features"]
    kinds = [feature["properties"]["kind"] for feature in features]
    assert kinds == ["home"] + ["item"] * 6 + ["route", "track"]
    assert features[2]["geometry"] is None
    assert features[3]["geometry"] == {"type": "Point", "coordinates": [8.54579412, 47.39794213, 519.75]}
    assert features[3]["properties"]["speed_m_s"] == 4.25
    assert features[-1]["geometry"]["coordinates"][0] == [8.5455, 47.3977]
    assert features[-1]["properties"]["time_s"] == [0.0, 0.4, 0.8, 1.2]


def test_unknown_heights_above_the_sea_are_left_out() -> None:
    """Points and lines have two coordinates then."""
    mission = Mission(MISSION.items[:4], replace(HOME, alt_amsl_m=None))
    features = json.loads(formats.geojson.text(mission))["features"]
    assert features[0]["geometry"]["coordinates"] == [HOME.lon_deg, HOME.lat_deg]
    assert features[0]["properties"]["alt_amsl_m"] is None
    assert {len(place) for place in features[-1]["geometry"]["coordinates"]} == {2}


@pytest.mark.parametrize(
    ("lons", "parts"),
    [
        ((179.9, -179.9), [[[179.9, 0.0], [180.0, 0.5]], [[-180.0, 0.5], [-179.9, 1.0]]]),
        ((-179.9, 179.9), [[[-179.9, 0.0], [-180.0, 0.5]], [[180.0, 0.5], [179.9, 1.0]]]),
        ((-180.0, 180.0), [[[-180.0, 0.0], [-180.0, 0.0]], [[180.0, 0.0], [180.0, 1.0]]]),
    ],
)
def test_geojson_cuts_lines_at_the_antimeridian(
    lons: tuple[float, float], parts: list[list[list[float]]]
) -> None:
    """No line runs around the earth (RFC 7946, 3.1.9)."""
    mission = Mission((waypoint(0.0, lons[0], 1.0), waypoint(1.0, lons[1], 1.0)))
    line = json.loads(formats.geojson.text(mission))["features"][-1]["geometry"]
    assert line["type"] == "MultiLineString"
    assert np.allclose(line["coordinates"], parts)
