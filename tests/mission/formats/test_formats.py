"""formats: missions and tracks to and from the files that other programs read."""

import csv
import json
import math
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree as Xml

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flight_replay.errors import FlightReplayError, MissionError
from flight_replay.logs.track import Track, track_from_columns
from flight_replay.mission import formats
from flight_replay.mission.items import Command, Frame, Home, Mission, MissionItem, change_speed, waypoint

HOME = Home(47.39774213, 8.54559412, 488.25)
MISSION = Mission(
    (
        waypoint(47.39784213, 8.54569412, 30.0),
        change_speed(4.25),
        waypoint(47.39794213, 8.54579412, 31.5, hold_s=2, spline=True),
        waypoint(47.39804213, 8.54589412, 32.0, spline=True),
        MissionItem(Command.WAYPOINT, Frame.ABSOLUTE, (0.0, 0.0, 0.0, 0.0), 47.398, 8.546, 520.0),
        MissionItem(Command.RETURN_TO_LAUNCH, Frame.MISSION, (0.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0),
    ),
    HOME,
)


@pytest.fixture
def track() -> Track:
    """Four fixes in two boots, one of them without a height above the sea."""
    return track_from_columns(
        np.array([0.0, 0.4, 0.8, 1.2]),
        np.array([47.3977, 47.3978, 47.3979, 47.398]),
        np.array([8.5455, 8.5456, 8.5457, 8.5458]),
        np.array([0.0, 1.0, 2.0, -0.0]),
        amsl_m=np.array([488.0, 489.0, np.nan, 488.0]),
        boot=np.array([0, 0, 1, 1], np.int32),
    )


def assert_same(mission: Mission, other: Mission) -> None:
    """Every number survives to 1e-8 in its unit; a place is then 1 mm off at most."""
    assert [(item.command, item.frame) for item in other.items] == [
        (item.command, item.frame) for item in mission.items
    ]
    for was, item in zip(mission.items, other.items, strict=True):
        wanted = (*was.params, was.lat_deg, was.lon_deg, was.alt_m)
        got = (*item.params, item.lat_deg, item.lon_deg, item.alt_m)
        assert got == pytest.approx(wanted, abs=0.6e-8, nan_ok=True)


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


def test_waypoints_is_what_pymavlink_reads(tmp_path: Path) -> None:
    """pymavlink's loader finds home as item 0 and every item after it, to 1e-8 degrees."""
    mavwp = pytest.importorskip("pymavlink.mavwp")
    path = tmp_path / "mission.waypoints"
    formats.save(path, MISSION)
    loader = mavwp.MAVWPLoader()
    assert loader.load(str(path)) == len(MISSION.items) + 1
    home = loader.wp(0)
    assert (home.frame, home.command, home.current, home.autocontinue) == (0, 16, 1, 1)
    assert (home.x, home.y, home.z) == pytest.approx((HOME.lat_deg, HOME.lon_deg, HOME.alt_amsl_m), abs=1e-8)
    for seq, item in enumerate(MISSION.items, 1):
        read = loader.wp(seq)
        assert (read.seq, read.command, read.frame, read.current) == (seq, item.command, item.frame, 0)
        assert (read.param1, read.param2, read.param3, read.param4) == item.params
        assert (read.x, read.y, read.z) == pytest.approx((item.lat_deg, item.lon_deg, item.alt_m), abs=1e-8)


def test_waypoints_has_twelve_columns_apart_by_tabs_and_eight_decimals(tmp_path: Path) -> None:
    """The text is the one of the format's page, home first."""
    lines = formats.wpl.text(MISSION).splitlines()
    assert lines[0] == "QGC WPL 110"
    assert lines[1] == "0\t1\t0\t16" + "\t0.00000000" * 4 + "\t47.39774213\t8.54559412\t488.25000000\t1"
    assert {len(line.split("\t")) for line in lines[1:]} == {12}


def test_waypoints_of_other_programs_are_read(tmp_path: Path) -> None:
    """Comments, blank lines, CRLF, a byte order mark, spaces and a home of command 0 do no harm."""
    path = tmp_path / "mission.waypoints"
    rows = ["# by hand", "0 1 0 0 0 0 0 0 47.1 8.1 400 1", "", "1 0 3 16 0 0 0 0 47.2 8.2 20 1", "# end"]
    path.write_bytes(b"\xef\xbb\xbf" + "\r\n".join(["QGC WPL 110", *rows]).encode())
    loaded = formats.load_mission(path)
    assert loaded.home == Home(47.1, 8.1, 400.0)
    assert loaded.items == (waypoint(47.2, 8.2, 20.0),)


def test_an_unknown_home_is_zeros_in_waypoints_and_the_first_waypoint_in_plan() -> None:
    """Zeros load as no home; QGroundControl, which wants one, gets the first waypoint's place."""
    mission = Mission(MISSION.items)
    assert formats.wpl.parse(formats.wpl.text(mission), "a file").home is None
    stand_in = formats.qgc_plan.parse(formats.qgc_plan.text(mission), "a file").home
    assert stand_in == Home(MISSION.items[0].lat_deg, MISSION.items[0].lon_deg, 0.0)
    assert formats.qgc_plan.parse(formats.qgc_plan.text(Mission(())), "a file") == Mission(
        (), Home(0.0, 0.0, 0.0)
    )


def test_a_waypoints_file_may_lack_home() -> None:
    """A first line that isn't numbered 0 is an item."""
    loaded = formats.wpl.parse("QGC WPL 110\n1 0 3 16 0 0 0 0 47.2 8.2 20 1\n", "a file")
    assert loaded == Mission((waypoint(47.2, 8.2, 20.0),))
    assert formats.wpl.parse("QGC WPL 110\n", "a file") == Mission(())


def test_a_parameter_that_is_no_number_is_zero_in_waypoints_and_null_in_plan() -> None:
    """ArduCopter takes both for 0; the .plan keeps the difference."""
    item = MissionItem(16, 3, (0.0, 0.0, 0.0, math.nan), 47.0, 8.0, 10.0)
    mission = Mission((item,), HOME)
    assert formats.wpl.parse(formats.wpl.text(mission), "a file").items[0].params[3] == 0
    assert math.isnan(formats.qgc_plan.parse(formats.qgc_plan.text(mission), "a file").items[0].params[3])


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", 'does not begin with "QGC WPL 110"'),
        ("QGC WPL 100\n", 'does not begin with "QGC WPL 110"'),
        ("QGC WPL 110\n0 1 0 16\n", "line 2 has 4 columns instead of 12"),
        ("QGC WPL 110\n# c\n0 1 0 x 0 0 0 0 1 1 1 1\n", r"line 3 is invalid \(invalid literal"),
        ("QGC WPL 110\n0 1 0 16 a 0 0 0 1 1 1 1\n", r"line 2 is invalid \(could not convert"),
        ("QGC WPL 110\n0 1 0 16 inf 0 0 0 1 1 1 1\n", "line 2 has param1 inf, not between"),
        ("QGC WPL 110\n1 0 3 70000 0 0 0 0 1 1 1 1\n", "line 2 has command 70000, not between 0 and 65535"),
        ("QGC WPL 110\n1 0 3 -1 0 0 0 0 1 1 1 1\n", "line 2 has command -1, not between 0 and 65535"),
        ("QGC WPL 110\n1 0 300 16 0 0 0 0 1 1 1 1\n", "line 2 has frame 300, not between 0 and 255"),
        ("QGC WPL 110\n1 0 3 16 0 0 1e39 0 1 1 1 1\n", r"line 2 has param3 1e\+39, not between"),
        ("QGC WPL 110\n1 0 3 16 0 0 0 0 1 1 1e39 1\n", r"line 2 has altitude 1e\+39, not between"),
        ("QGC WPL 110\n1 0 3 178 0 0 0 0 1e9 1 1 1\n", r"line 2 has latitude 1e\+09, not between"),
        ("QGC WPL 110\n0 1 0 16 0 0 0 0 91 1 1 1\n", "line 2 has invalid coordinates"),
        ("QGC WPL 110\n1 0 3 82 0 0 0 0 1 nan 1 1\n", "line 2 has invalid coordinates"),
    ],
)
def test_broken_waypoints_are_told_with_their_line(content: str, said: str) -> None:
    """Each error names the file and the line, and what is wrong there."""
    with pytest.raises(MissionError, match=f"^m.waypoints.*{said}"):
        formats.wpl.parse(content, "m.waypoints")


def _plan(*rows: object, home: object = (1, 2, 3)) -> str:
    return json.dumps({"mission": {"plannedHomePosition": home, "items": rows}})


SIMPLE = {"type": "SimpleItem", "command": 16, "frame": 3, "params": [0, 0, 0, None, 1, 2, 3]}


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("{", "is not a QGroundControl plan"),
        ("[]", "is not a QGroundControl plan"),
        ('{"mission": {}}', "is not a QGroundControl plan"),
        (_plan(home=[1, 2]), "is not a QGroundControl plan"),
        (_plan({"type": "ComplexItem", "complexItemType": "survey"}), "item 1 is a survey pattern"),
        (_plan(SIMPLE, {**SIMPLE, "params": [0, 1]}), "item 2 is not a SimpleItem of seven numbers"),
        ("[" * 100_000, "is not a QGroundControl plan"),
        (_plan(home=[1e300, 2, 3]), "plannedHomePosition has invalid coordinates"),
        (_plan(home=[10**400, 2, 3]), "is not a QGroundControl plan"),
        (_plan({**SIMPLE, "command": 70000}), "item 1 has command 70000"),
        (_plan({**SIMPLE, "command": math.inf}), "item 1 is not a SimpleItem"),
        (_plan({**SIMPLE, "frame": 300}), "item 1 has frame 300"),
        (_plan({**SIMPLE, "params": [0, 0, 0, 1e39, 1, 2, 3]}), r"item 1 has param4 1e\+39"),
        (_plan("text"), "item 1 is not a SimpleItem"),
        (_plan({**SIMPLE, "params": [0, 0, 0, 0, None, 2, 3]}), "item 1 has invalid coordinates"),
    ],
)
def test_broken_plans_are_told_with_their_item(content: str, said: str) -> None:
    """Each error names the file and the item, and what is wrong there."""
    with pytest.raises(MissionError, match=f"^m.plan.*{said}"):
        formats.qgc_plan.parse(content, "m.plan")


def test_a_command_without_a_place_may_leave_its_coordinates_out() -> None:
    """A null is 0 in MAVLink's integers, which know no number that is none."""
    row = {**SIMPLE, "command": 178, "params": [1, 5, -1, 0, None, None, None]}
    item = formats.qgc_plan.parse(_plan(row), "m.plan").items[0]
    assert (item.lat_deg, item.lon_deg) == (0.0, 0.0)


def test_a_mission_that_mavlink_cannot_count_is_told(tmp_path: Path) -> None:
    """MISSION_COUNT has 16 bits, and home is one of the items."""
    path = tmp_path / "m.waypoints"
    path.write_text("QGC WPL 110\n" + "1 0 3 16 0 0 0 0 1 1 1 1\n" * 65535)
    with pytest.raises(MissionError, match="has 65535 items, more than the 65534"):
        formats.load_mission(path)


PLAN_SCHEMA = {
    "type": "object",
    "required": ["fileType", "version", "groundStation", "mission", "geoFence", "rallyPoints"],
    "properties": {
        "fileType": {"const": "Plan"},
        "version": {"const": 1},
        "groundStation": {"type": "string"},
        "mission": {
            "type": "object",
            "required": [
                "version",
                "firmwareType",
                "vehicleType",
                "cruiseSpeed",
                "hoverSpeed",
                "plannedHomePosition",
                "items",
            ],
            "properties": {
                "version": {"const": 2},
                "firmwareType": {"const": 3},
                "vehicleType": {"const": 2},
                "cruiseSpeed": {"type": "number", "exclusiveMinimum": 0},
                "hoverSpeed": {"type": "number", "exclusiveMinimum": 0},
                "globalPlanAltitudeMode": {"type": "integer"},
                "plannedHomePosition": {
                    "type": "array",
                    "items": {"type": "number"},
                    "minItems": 3,
                    "maxItems": 3,
                },
                "items": {"type": "array", "items": {"$ref": "#/$defs/simple"}},
            },
        },
        "geoFence": {
            "required": ["version", "circles", "polygons"],
            "properties": {"version": {"const": 2}},
        },
        "rallyPoints": {"required": ["version", "points"], "properties": {"version": {"const": 2}}},
    },
    "$defs": {
        "simple": {
            "type": "object",
            "required": ["type", "autoContinue", "command", "doJumpId", "frame", "params"],
            "properties": {
                "type": {"const": "SimpleItem"},
                "autoContinue": {"type": "boolean"},
                "command": {"type": "integer", "minimum": 0},
                "doJumpId": {"type": "integer", "minimum": 1},
                "frame": {"enum": [0, 2, 3, 10]},
                "params": {
                    "type": "array",
                    "items": {"type": ["number", "null"]},
                    "minItems": 7,
                    "maxItems": 7,
                },
                "AltitudeMode": {"enum": [1, 2, 3, 4]},
                "Altitude": {"type": "number"},
                "AMSLAltAboveTerrain": {"type": ["number", "null"]},
            },
            "if": {"properties": {"command": {"enum": [16, 82]}}},
            "then": {"required": ["AltitudeMode", "Altitude", "AMSLAltAboveTerrain"]},
        }
    },
}
"""The .plan format of QGroundControl's developer guide, as far as missions go."""


def test_plan_keeps_to_the_format_of_the_developer_guide() -> None:
    """The file agrees with a JSON schema of the guide's tables."""
    jsonschema = pytest.importorskip("jsonschema")
    plan = json.loads(formats.qgc_plan.text(MISSION))
    jsonschema.validate(plan, PLAN_SCHEMA)
    first = plan["mission"]["items"][0]
    assert (first["Altitude"], first["AltitudeMode"], first["doJumpId"]) == (30.0, 1, 1)
    assert plan["mission"]["items"][4]["AltitudeMode"] == 2
    assert "AltitudeMode" not in plan["mission"]["items"][1]
    assert plan["mission"]["hoverSpeed"] == 4.25
    assert plan["mission"]["plannedHomePosition"] == [HOME.lat_deg, HOME.lon_deg, HOME.alt_amsl_m]


KML = "{http://www.opengis.net/kml/2.2}"


def test_kml_pins_every_waypoint_above_the_sea_and_draws_route_and_track(track: Track) -> None:
    """Heights are home's plus the item's; a fix whose height is unknown does not break the line."""
    root = Xml.fromstring(formats.kml.text(MISSION, track))
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


GPX = "{http://www.topografix.com/GPX/1/1}"


def test_gpx_holds_home_the_route_and_one_segment_a_boot(track: Track) -> None:
    """Home is a waypoint, the mission a route, the track a track; unknown elevations are left out."""
    root = Xml.fromstring(formats.gpx.text(MISSION, track))
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


def test_gpx_longitudes_end_below_180() -> None:
    """GPX 1.1 allows -180 but not 180."""
    root = Xml.fromstring(formats.gpx.text(Mission((waypoint(0.0, 180.0, 1.0),))))
    assert [point.get("lon") for point in root.iter(f"{GPX}rtept")] == ["-180.00000000"]


def test_geojson_has_a_feature_for_every_item_and_lines_for_route_and_track(track: Track) -> None:
    """Places are points, other items have no geometry, properties carry what MAVLink says."""
    features = json.loads(formats.geojson.text(MISSION, track))["features"]
    kinds = [feature["properties"]["kind"] for feature in features]
    assert kinds == ["home"] + ["item"] * 6 + ["route", "track"]
    assert features[2]["geometry"] is None
    assert features[3]["geometry"] == {"type": "Point", "coordinates": [8.54579412, 47.39794213, 519.75]}
    assert features[3]["properties"]["speed_m_s"] == 4.25
    assert features[-1]["geometry"]["coordinates"][0] == [8.5455, 47.3977]
    assert features[-1]["properties"]["time_s"] == [0.0, 0.4, 0.8, 1.2]


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


def test_csv_is_one_table_told_apart_by_kind(tmp_path: Path, track: Track) -> None:
    """Home, items and fixes are rows; what a row cannot have is an empty cell."""
    path = tmp_path / "mission.csv"
    formats.save(path, MISSION, track)
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["kind"] for row in rows] == ["home"] + ["item"] * 6 + ["track"] * 4
    assert (rows[3]["seq"], rows[3]["command_name"], rows[3]["param1"]) == ("3", "spline waypoint", "2")
    assert (rows[3]["lat_deg"], rows[3]["alt_m"], rows[3]["amsl_m"]) == ("47.39794213", "31.5", "519.75")
    assert (rows[2]["command_name"], rows[2]["param2"], rows[2]["amsl_m"]) == ("change speed", "4.25", "")
    assert (rows[9]["amsl_m"], rows[9]["north_m_s"], rows[10]["alt_m"]) == ("", "", "0")


def test_a_command_without_a_word_is_its_number() -> None:
    """Nothing is lost of a mission that another program made."""
    mission = Mission((MissionItem(206, 2, (25.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0),))
    assert "command 206" in formats.csv_table.text(mission)
    assert "item" not in formats.csv_table.text(Mission(()))


@pytest.mark.parametrize(
    ("suffix", "kind", "counts"),
    [(".kml", "kml", (5, 0, 4)), (".gpx", "gpx", (1, 4, 4))],
)
def test_gpsbabel_reads_kml_and_gpx(
    tmp_path: Path, track: Track, suffix: str, kind: str, counts: tuple[int, int, int]
) -> None:
    """GPSBabel finds every waypoint, route point and track point; KML's route line is one more track."""
    if shutil.which("gpsbabel") is None:
        pytest.skip("gpsbabel is not installed")
    path, out = tmp_path / f"mission{suffix}", tmp_path / "out.gpx"
    formats.save(path, MISSION, track)
    command = ["gpsbabel", "-w", "-r", "-t", "-i", kind, "-f", str(path), "-o", "gpx", "-F", str(out)]
    subprocess.run(command, check=True, timeout=20, capture_output=True)
    names = [element.tag.rpartition("}")[2] for element in Xml.parse(out).getroot().iter()]
    lines = len(formats.item_text.route_line(MISSION)[0]) if kind == "kml" else 0
    assert (names.count("wpt"), names.count("rtept"), names.count("trkpt") - lines) == counts
