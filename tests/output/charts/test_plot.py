"""plot.py: one page of pictures of a replay."""

import re
from pathlib import Path
from xml.etree import ElementTree as Xml

import pytest

from flight_replay.errors import FlightReplayError
from flight_replay.output.charts.plot import save_plot, scale_bar_m
from flight_replay.planning.spacing import spaced_route
from tests.helpers.made_replays import eight, replay

MAGIC = {".png": b"\x89PNG\r\n\x1a\n", ".svg": b"<?xml", ".pdf": b"%PDF-"}


@pytest.mark.parametrize("suffix", MAGIC)
def test_the_suffix_decides_the_format(tmp_path: Path, suffix: str) -> None:
    """Each file begins like its kind and is the same twice."""
    path, again = tmp_path / f"a{suffix}", tmp_path / f"b{suffix.upper()}"
    save_plot(path, *replay())
    save_plot(again, *replay())
    assert path.read_bytes().startswith(MAGIC[suffix])
    assert path.read_bytes() == again.read_bytes()


def words(path: Path, monkeypatch: pytest.MonkeyPatch, *, flown: bool) -> list[str]:
    """Every text in an SVG of the replay; matplotlib leaves each as a comment beside its outlines."""
    route, record, outcome = replay()
    save_plot(path, route, *((record, outcome) if flown else ()))
    return [text.strip() for text in re.findall(r"<!--(.*?)-->", path.read_text(), re.DOTALL)]


def test_the_page_says_what_it_shows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Axes have labels with units, the map a scale bar and north, the lines names, the panels numbers."""
    said = words(tmp_path / "a.svg", monkeypatch, flown=True)
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
        "distance in space",
        "distance in time",
    ):
        assert text in said
    assert said.count("time since the first fix / first waypoint (s)") == 4
    assert any(re.fullmatch(r"mean \d+\.\d\d, 95 % \d+\.\d\d, max \d+\.\d\d m", text) for text in said)


def test_a_plan_alone_is_drawn_without_flown_lines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A dry run has a plot too: paths, planned distance, altitude and speed."""
    said = words(tmp_path / "a.svg", monkeypatch, flown=False)
    assert "flown" not in said
    assert "distance in time" not in said
    assert "planned distance in space" in said
    Xml.parse(tmp_path / "a.svg")


def test_a_single_fix_can_be_drawn(tmp_path: Path) -> None:
    """A hovering or very short log gives a picture, not an error."""
    save_plot(tmp_path / "a.png", spaced_route(eight().select(slice(0, 1))))
    assert (tmp_path / "a.png").stat().st_size > 10_000


def test_north_and_east_have_the_same_scale_and_the_bar_keeps_to_it(tmp_path: Path) -> None:
    """A metre is as long up as across, and as on the scale bar, on the page itself."""
    save_plot(tmp_path / "a.svg", *replay())
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


def test_other_suffixes_are_told(tmp_path: Path) -> None:
    """One sentence names the file and the formats."""
    with pytest.raises(FlightReplayError, match=r'a\.gif: unknown suffix "\.gif"; use one of \.png, '):
        save_plot("a.gif", replay()[0])


@pytest.mark.parametrize(("width_m", "bar_m"), [(100, 20), (99, 10), (260, 50), (0.4, 0.05), (7e4, 1e4)])
def test_the_scale_bar_is_round_and_about_a_fifth(width_m: float, bar_m: float) -> None:
    """1, 2 or 5 and zeros."""
    assert scale_bar_m(width_m) == pytest.approx(bar_m)
