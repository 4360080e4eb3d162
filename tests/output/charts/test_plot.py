"""plot.py: one page of plots of a replay."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as Xml

import numpy as np
import pytest

from flight_replay.exceptions import FlightReplayError
from flight_replay.output.charts.plot import replay_figure, save_plot, scale_bar_m
from flight_replay.output.charts.series import FLOWN_COLOUR
from flight_replay.output.outcome import Outcome, compare_flight
from flight_replay.planning.following.followed_route import FollowOptions, followed_route
from flight_replay.planning.prediction import with_prediction
from flight_replay.planning.route import Route
from flight_replay.planning.spacing import spaced_route
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.made_replays import figure_of_eight, made_following, made_replay
from tests.helpers.made_tracks import straight_track

MAGIC = {".png": b"\x89PNG\r\n\x1a\n", ".svg": b"<?xml", ".pdf": b"%PDF-"}


@pytest.mark.parametrize("suffix", MAGIC)
def test_the_suffix_decides_the_format(tmp_path: Path, suffix: str) -> None:
    """Each file has its format's signature and is the same twice."""
    path, again = tmp_path / f"a{suffix}", tmp_path / f"b{suffix.upper()}"
    save_plot(path, *made_replay())
    save_plot(again, *made_replay())
    assert path.read_bytes().startswith(MAGIC[suffix])
    assert path.read_bytes() == again.read_bytes()


@pytest.mark.parametrize(("speed_m_s", "marker"), [(0.0, "o"), (4.0, "None")])
def test_a_flight_straight_up_is_a_dot_on_the_map(speed_m_s: float, marker: str) -> None:
    """A line without length is not drawn; followed in GUIDED, it has no waypoint either."""
    track = straight_track(speed_m_s, altitudes_m=np.linspace(10.0, 40.0, 51).tolist())
    recorded = replay_figure(followed_route(track, track.alt_m, Limits(), FollowOptions())).axes[0].lines[0]
    assert (recorded.get_label(), recorded.get_marker()) == ("recorded", marker)


def test_the_speed_of_a_hover_is_next_to_nothing() -> None:
    """Of a vehicle that only climbs, millimetres a second must not look like much."""
    lift = straight_track(speed_m_s=1e-3, altitudes_m=np.linspace(10.0, 40.0, 51).tolist())
    speed = replay_figure(spaced_route(lift, altitude_m="recorded")).axes[-1]
    assert (speed.get_title(), speed.get_ylim()[1]) == ("ground speed", 0.1)


def texts(path: Path, monkeypatch: pytest.MonkeyPatch, *, flown: bool) -> list[str]:
    """Every text in an SVG of the replay; matplotlib leaves each as a comment beside its outlines."""
    route, outcome = made_replay()
    save_plot(path, route, outcome if flown else None)
    return [text.strip() for text in re.findall(r"<!--(.*?)-->", path.read_text(encoding="utf-8"), re.DOTALL)]


def test_lines_axes_and_panels_are_labelled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Axes have units, the map has a scale bar and north, lines have names, panels have statistics."""
    shown = texts(tmp_path / "a.svg", monkeypatch, flown=True)
    for text in (
        "recorded",
        "planned",
        "flown",
        "waypoints",
        "first waypoint",
        "east of the first fix (m)",
        "north of the first fix (m)",
        "20 m",
        "N",
        "altitude (m)",
        "speed (m/s)",
        "ground speed",
        "altitude above home",
        "recorded, not covered",
        "path error, recorded to flown",
        "path error, flown to recorded",
        "position error",
        "height error",
    ):
        assert text in shown
    assert shown.count("time since the first fix / first waypoint (s)") == 6
    assert any(re.fullmatch(r"mean \d+\.\d\d m, p95 \d+\.\d\d m, max \d+\.\d\d m", text) for text in shown)


def test_a_plan_is_drawn_without_flown_lines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A dry run has a plot too: paths, planned path error, altitude and speed."""
    shown = texts(tmp_path / "a.svg", monkeypatch, flown=False)
    assert "flown" not in shown
    assert "position error" not in shown
    assert "planned path error, recorded to planned" in shown
    assert "planned path error, planned to recorded" in shown
    Xml.parse(tmp_path / "a.svg")


def test_a_plan_is_drawn_with_what_is_predicted(tmp_path: Path) -> None:
    """Path, heights, speeds and every error."""
    save_plot(tmp_path / "a.svg", with_prediction(made_replay()[0], 30.0))
    page = (tmp_path / "a.svg").read_text(encoding="utf-8")
    for text in (
        "predicted",
        "predicted path error, recorded to flown",
        "predicted path error, flown to recorded",
        "predicted position error",
        "predicted height error",
    ):
        assert text in page


def broken_off() -> tuple[Route, Outcome]:
    """The replay with the first waypoint reached, and nothing flown after that."""
    route, outcome = made_replay()
    record = outcome.record
    flown = record.flown.select(record.flown.time_s <= 1001.6)
    record = replace(record, waypoints_reached=1, reached=((1, 1001.7),), flown=flown)
    return route, compare_flight(route, record)


def test_what_is_only_planned_is_not_told_as_flown() -> None:
    """Of a flight that ended at its first waypoint, one direction of the path error is known."""
    titles = [axes.get_title().splitlines()[0] for axes in replay_figure(*broken_off()).axes[1:]]
    assert titles[:2] == ["path error, recorded to flown", "planned path error, planned to recorded"]


@pytest.mark.parametrize("replay", [broken_off, made_replay], ids=["two rows", "three rows"])
def test_the_scale_bar_is_not_in_the_title_of_a_panel(
    replay: Callable[[], tuple[Route, Outcome]],
) -> None:
    """However high the map is."""
    figure = replay_figure(*replay())
    (length,) = [text for text in figure.axes[0].texts if text.get_text() == "20 m"]
    assert length.get_window_extent().y0 > figure.axes[2].title.get_window_extent().y1


def test_a_recording_without_times_has_no_line_over_time() -> None:
    """Neither at the first fix's time nor at a speed; the flown one has its lines."""
    _, outcome = made_replay()
    route = spaced_route(replace(figure_of_eight(), timed=False), spacing_m=6.0, max_points=60)
    axes = replay_figure(route, compare_flight(route, outcome.record)).axes
    assert [each.get_title().splitlines()[0] for each in axes[1:]] == [
        "path error, recorded to flown",
        "path error, flown to recorded",
        "altitude above home",
        "ground speed",
    ]
    (flown,) = axes[4].lines
    assert flown.get_color() == FLOWN_COLOUR
    assert "5 m/s" in axes[1].get_xlabel()
    assert axes[4].get_xlabel() == "time since the first waypoint (s)"


def test_a_single_fix_can_be_drawn(tmp_path: Path) -> None:
    """A log of a hover gives a plot, not an error."""
    save_plot(tmp_path / "a.png", spaced_route(figure_of_eight().select(slice(0, 1))))
    assert (tmp_path / "a.png").stat().st_size > 10_000


def test_the_map_of_a_hover_is_some_metres_wide() -> None:
    """Neither noise nor rounding looks like a way; the single errors and the recorded height are dots."""
    hover = figure_of_eight().select(slice(0, 1))
    figure = replay_figure(with_prediction(spaced_route(hover), 30.0))
    paths, *errors, altitude, _ = figure.axes
    for low, high in (paths.get_xlim(), paths.get_ylim()):
        assert (low + high) / 2 == pytest.approx(0.0, abs=0.01)
        assert 5.0 <= high - low < 15.0
    assert "1 m" in [text.get_text() for text in paths.texts]
    assert len(errors) == 4
    for axes in errors:
        assert list(axes.get_ylim()) == pytest.approx([0.0, 0.1], abs=0.006)
    lines = [line for axes in (*errors, altitude) for line in axes.lines]
    single = [line for line in lines if np.size(line.get_ydata()) == 1 and line.get_linestyle() == "-"]
    assert len(single) >= 5
    assert {line.get_marker() for line in single} == {"."}


def test_north_and_east_and_the_scale_bar_have_one_scale(tmp_path: Path) -> None:
    """A metre has one length on the page."""
    save_plot(tmp_path / "a.svg", *made_replay())
    root = Xml.parse(tmp_path / "a.svg").getroot()
    groups = {group.get("id"): group for group in root.iter("{http://www.w3.org/2000/svg}g")}
    across = tick_step(groups, "xtick", 1) / 20
    assert tick_step(groups, "ytick", 1) / 10 == pytest.approx(across, rel=1e-3)
    bar = next(groups["scale-bar"].iter("{http://www.w3.org/2000/svg}path")).get("d", "")
    (x0, _), (x1, _) = re.findall(r"[ML] ([-\d.]+) ([-\d.]+)", bar)
    assert float(x1) - float(x0) == pytest.approx(20 * across, rel=1e-3)


def tick_step(groups: dict[str | None, Xml.Element], kind: str, first: int) -> float:
    """Points on the page between two ticks of the map."""
    axis = "x" if kind == "xtick" else "y"
    places = [
        float(next(groups[f"{kind}_{n}"].iter("{http://www.w3.org/2000/svg}use")).get(axis, "nan"))
        for n in (first, first + 1)
    ]
    return abs(places[1] - places[0])


def test_other_suffixes_are_refused(tmp_path: Path) -> None:
    """The error names the file and the formats."""
    with pytest.raises(FlightReplayError, match=r'a\.gif: unknown suffix "\.gif"; use one of \.png, '):
        save_plot("a.gif", made_replay()[0])


@pytest.mark.parametrize(("width_m", "bar_m"), [(100, 20), (99, 10), (260, 50), (0.4, 0.05), (7e4, 1e4)])
def test_the_scale_bar_is_round_and_about_a_fifth(width_m: float, bar_m: float) -> None:
    """1, 2 or 5 times a power of ten."""
    assert scale_bar_m(width_m) == pytest.approx(bar_m)


def test_a_recording_that_is_followed_is_drawn_without_waypoints(tmp_path: Path) -> None:
    """There are none; the lines are there."""
    save_plot(tmp_path / "a.svg", *made_following())
    page = (tmp_path / "a.svg").read_text(encoding="utf-8")
    assert "<!-- flown -->" in page
    assert page.count("<!-- time of the recording (s) -->") == 6
    assert "waypoints -->" not in page
