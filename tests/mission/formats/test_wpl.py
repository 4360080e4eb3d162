"""QGC WPL 110: what pymavlink and Mission Planner read and write, and what is refused."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from flight_replay.exceptions import MissionError
from flight_replay.mission import formats
from flight_replay.mission.items import Home, Mission, MissionItem, waypoint
from tests.helpers.format_examples import HOME, MISSION


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


def test_a_home_of_unknown_height_is_at_0() -> None:
    """Both formats have a number there."""
    mission = MISSION.with_home(replace(HOME, alt_amsl_m=None))
    for written in (
        formats.wpl.parse(formats.wpl.text(mission), "a file"),
        formats.qgc_plan.parse(formats.qgc_plan.text(mission), "a file"),
    ):
        assert written.home == replace(HOME, alt_amsl_m=0.0)


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
