"""report.py: the report in one self-contained HTML file."""

import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from flight_replay.exceptions import FlightReplayError
from flight_replay.mission.items import Command, Frame, MissionItem, change_climb_speed
from flight_replay.output.charts.report import ReportText, _time_charts, save_report
from flight_replay.output.charts.series import replay_series
from flight_replay.output.event_log import LoggedEvent
from flight_replay.output.json_summary import flight_summary, route_summary
from flight_replay.planning.spacing import spaced_route
from tests.helpers.made_replays import figure_of_eight, made_following, made_replay
from tests.helpers.made_tracks import straight_track


def summary(*, flown: bool = True) -> dict[str, Any]:
    """A ``--json`` object that fits the made-up replay."""
    route, outcome = made_replay()
    flight = dict(flight_summary("ArduCopter V4.6.0", True, outcome))
    flight["position_error_m"] = {"mean": None, "p95": None, "max": None}
    return {
        "log": {
            "path": "/logs/<b>flight.tlog",
            "format": "dataflash",
            "firmware": "ArduCopter V4.6.0",
            "vehicle_type": "quadcopter",
            "start_utc_s": 1_700_000_000.0,
            "bytes": 12,
            "fixes": 300,
            "without_position": 7,
            "rejected": 0,
            "vehicles": [{"system": 1, "component": 1, "fixes": 300}],
            "flights": [],
        },
        "route": route_summary(route),
        "flight": flight if flown else None,
    }


class Page(HTMLParser):
    """The texts of a page outside scripts and styles, the files it refers to, and its table rows."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.references: list[str] = []
        self.texts: list[str] = []
        self.rows: list[list[str]] = []
        self._silent = 0
        self._in_row = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._silent += tag in {"script", "style"}
        self.references += [value or "" for name, value in attrs if name in {"src", "href"}]
        if tag == "tr":
            self.rows.append([])
            self._in_row = True

    def handle_endtag(self, tag: str) -> None:
        self._silent -= tag in {"script", "style"}
        self._in_row = self._in_row and tag != "tr"

    def handle_data(self, data: str) -> None:
        if data.strip() and not self._silent:
            text = " ".join(data.split())
            self.texts.append(text)
            if self._in_row:
                self.rows[-1].append(text)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Page:
    """The report of the made-up replay."""
    path = tmp_path_factory.mktemp("report") / "replay.html"
    route, outcome = made_replay()
    record = replace(outcome.record, problem="the vehicle did not confirm RTL")
    events = (LoggedEvent(None, "Arm and Takeoff", False), LoggedEvent(12.3, "Warning: <lost>", True))
    text = ReportText(summary(), events, ["--tlog", "my flight.tlog", "--speedup", "10"])
    save_report(path, text, route, replace(outcome, record=record))
    return Page(path.read_text(encoding="utf-8"))


def test_the_file_refers_to_no_other(page: Page) -> None:
    """Scripts, styles and data are inside."""
    assert page.references == []


def test_the_report_has_the_results(page: Page) -> None:
    """Log, route and flight as in ``--json``, with units."""
    rows = {row[0]: row[1:] for row in page.rows if row}
    assert rows["date"] == ["2023-11-14 22:13:20 UTC"]
    assert rows["place"] == ["home at 47.397700°, 8.545600°"]
    assert rows["duration"] == ["2 min 0 s"]
    assert rows["usable fixes"] == ["300"]
    assert rows["records without a position"] == ["7"]
    assert rows["waypoints reached"][0].startswith(f"{summary()['flight']['waypoints_reached']} of ")
    assert rows["time in AUTO"] == ["60.0 s"]
    for label in ("path error, recorded to flown", "path error, flown to recorded", "height error"):
        assert re.fullmatch(r"mean [\d.]+ m, p95 [\d.]+ m, max [\d.]+ m", rows[label][0])
    assert rows["heading error"] == ["nothing to compare"]
    assert rows["flown"] == ["the first 1 min 59 s of 2 min 0 s of recorded flight"]
    assert rows["to fly all of it"] == ["--duration all"]
    assert rows["position error"] == ["nothing to compare"]
    assert rows["problem"] == ["the vehicle did not confirm RTL"]


def test_the_report_lists_mission_and_events(page: Page) -> None:
    """Each item with its position and the time when it was reached; each event with the vehicle's time."""
    rows = {row[0]: row for row in page.rows if row}
    assert rows["1"] == ["1", "waypoint, 30 m above home", "47.3977000", "8.5456000", "30.0", "0.0"]
    assert rows["2"][-1] == "2.0"
    assert ["12.3", "Warning: <lost>"] in page.rows


def test_a_height_of_nothing_is_not_negative(tmp_path: Path) -> None:
    """Nor is the time when the first waypoint is reached."""
    route, outcome = made_replay()
    first = replace(route.mission.items[0], alt_m=-0.04)
    low = replace(route, mission=replace(route.mission, items=(first, *route.mission.items[1:])))
    save_report(tmp_path / "a.html", ReportText(summary()), low, outcome)
    page = Page((tmp_path / "a.html").read_text(encoding="utf-8"))
    assert ["1", "waypoint, 0 m above home", "47.3977000", "8.5456000", "0.0", "0.0"] in page.rows


def test_no_time_is_told_of_a_turn(tmp_path: Path) -> None:
    """The vehicle reads it as it passes the waypoint before, and makes it later."""
    route, outcome = made_replay()
    first, *others = route.mission.items
    turn = MissionItem(Command.CONDITION_YAW, Frame.RELATIVE, (90.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0)
    turning = replace(route, mission=replace(route.mission, items=(first, turn, *others)))
    record = replace(outcome.record, reached=tuple((seq, 100.0 + seq) for seq in (1, 2, 3)))
    save_report(tmp_path / "a.html", ReportText(summary()), turning, replace(outcome, record=record))
    rows = {row[0]: row for row in Page((tmp_path / "a.html").read_text(encoding="utf-8")).rows if row}
    assert rows["2"] == ["2", "turn to 90°"]
    assert rows["3"][-1] == "2.0"


def test_the_report_has_the_command(page: Page) -> None:
    """It can be pasted into a shell."""
    assert "flight-replay --tlog 'my flight.tlog' --speedup 10" in page.texts


def test_file_names_are_escaped(page: Page) -> None:
    """Markup in a file name is shown as text."""
    assert page.texts[0] == "Replay of <b>flight.tlog"


def test_a_plan_has_a_report(tmp_path: Path) -> None:
    """It has no flight and no events; its mission lists speed changes. A log may know of no vehicle."""
    route = spaced_route(figure_of_eight(), spacing_m=6.0, max_points=60, speed_m_s=3.0)
    planned = summary(flown=False)
    planned["log"]["vehicles"] = []
    save_report(tmp_path / "a.html", ReportText(planned), route)
    page = Page((tmp_path / "a.html").read_text(encoding="utf-8"))
    assert "Plan only: nothing was flown." in page.texts
    assert "Flight" not in page.texts
    assert "Events" not in page.texts
    assert "vehicles" not in page.texts
    assert ["1", "wait here for 1 s"] in page.rows
    assert ["2", "change speed to 3 m/s"] in page.rows


def test_climb_speeds_are_told_from_ground_speeds(tmp_path: Path) -> None:
    """A mission may change each."""
    route = spaced_route(figure_of_eight(), spacing_m=6.0, max_points=60)
    items = (change_climb_speed(0.5), change_climb_speed(-1.5), *route.mission.items)
    slow = replace(route, mission=replace(route.mission, items=items))
    save_report(tmp_path / "a.html", ReportText(summary(flown=False)), slow)
    page = Page((tmp_path / "a.html").read_text(encoding="utf-8"))
    assert ["1", "change climb speed to 0.5 m/s"] in page.rows
    assert ["2", "change descent speed to 1.5 m/s"] in page.rows


def test_altitude_and_speed_are_shown_from_0() -> None:
    """Millimetres around 30 m must not look like much."""
    charts: list[Any] = list(_time_charts(replay_series(*made_replay())))
    assert [chart.y_range.start for chart in charts[-2:]] == [0, 0]


def test_the_speed_of_a_hover_is_next_to_nothing() -> None:
    """Of a vehicle that only climbs, millimetres a second must not look like much."""
    lift = straight_track(speed_m_s=1e-3, altitudes_m=[float(height) for height in range(5, 56)])
    charts: list[Any] = list(_time_charts(replay_series(spaced_route(lift, altitude_m="recorded"))))
    assert (charts[-1].title.text, charts[-1].y_range.end) == ("ground speed", 0.1)


def test_a_plan_without_recorded_times_has_no_chart_over_time() -> None:
    """Nothing is drawn at a speed that nobody recorded."""
    route = spaced_route(replace(figure_of_eight(), timed=False), spacing_m=6.0)
    charts: list[Any] = list(_time_charts(replay_series(route)))
    titles = [chart.title.text for chart in charts]
    assert titles == ["path error: recorded fixes to the path", "path error: the path to the recorded line"]


def test_an_unplanned_end_is_at_the_top(tmp_path: Path) -> None:
    """Such as a flight that a pilot took over."""
    route, outcome = made_replay()
    ended = replace(outcome, record=replace(outcome.record, ended="pilot"))
    save_report(tmp_path / "a.html", ReportText(summary()), route, ended)
    assert "did not end as planned: pilot." in (tmp_path / "a.html").read_text(encoding="utf-8")


def test_other_suffixes_are_refused() -> None:
    """The error names the file and the suffixes."""
    route, _ = made_replay()
    with pytest.raises(FlightReplayError, match=r'a\.pdf: unknown suffix "\.pdf"; use one of \.html'):
        save_report("a.pdf", ReportText(summary()), route)


def test_a_recording_that_is_followed_has_a_report(tmp_path: Path) -> None:
    """Its motion stands where a mission has its waypoints, and there is no table of items."""
    route, outcome = made_following(waits_at_s=40.0, waits_s=7.0)
    results = summary() | {
        "route": route_summary(route),
        "flight": flight_summary("ArduCopter V4.6.0", True, outcome),
    }
    whole = replace(outcome, record=replace(outcome.record, ended="recording complete"))
    save_report(tmp_path / "a.html", ReportText(results), route, whole)
    page = Page((tmp_path / "a.html").read_text(encoding="utf-8"))
    rows = {row[0]: row[1:] for row in page.rows if row}
    assert "The whole motion was followed." in page.texts
    assert "Mission" not in page.texts
    assert rows["altitude above home"] == ["30.0 to 30.0 m"]
    assert rows["waited for the vehicle"] == ["7.0 s"]
    assert "time in GUIDED" in rows
    assert not {"waypoints", "waypoints reached", "time in AUTO"} & rows.keys()
