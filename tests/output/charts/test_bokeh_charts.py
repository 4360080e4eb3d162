"""bokeh_charts.py: the map chart and charts over time."""

from typing import Any

import numpy as np
import pytest
from bokeh.models import Scatter, Text
from bokeh.models.annotations import Label, ScaleBar

from flight_replay.output.charts.bokeh_charts import (
    LABEL_GAP_SHARE,
    add_line,
    label_indices,
    left_of_path,
    map_chart,
    time_chart,
)
from flight_replay.output.charts.series import PREDICTED_COLOUR, RECORDED_COLOUR, replay_series
from flight_replay.planning.prediction import with_prediction
from flight_replay.planning.spacing import spaced_route
from tests.helpers.made_replays import figure_of_eight, made_replay


def test_the_map_is_to_scale_and_labelled_with_units() -> None:
    """A metre is as long up as across; both axes say what they are."""
    chart = map_chart(replay_series(*made_replay()))
    assert chart.match_aspect
    assert chart.xaxis[0].axis_label == "east of the first fix (m)"
    assert chart.yaxis[0].axis_label == "north of the first fix (m)"
    legend: Any = chart.legend[0]
    assert [item.label.value for item in legend.items] == [
        "recorded, not covered",
        "recorded",
        "planned",
        "waypoints",
        "home (launch)",
    ]


def test_the_map_has_home_a_scale_bar_and_north() -> None:
    """Home is a source that can be moved; the corners have the rest."""
    chart = map_chart(replay_series(*made_replay()))
    home: Any = chart.select_one({"name": "home"})
    assert home.data["north"] == [pytest.approx(0, abs=1e-3)]
    bar: Any = chart.select_one({"type": ScaleBar})
    north: Any = chart.select_one({"type": Label})
    assert bar.location == "bottom_right"
    assert north.text.startswith("N")


def test_the_map_of_a_hover_is_some_metres_wide() -> None:
    """Rounding does not look like a way: what is not seen keeps the ranges apart."""
    hover = replay_series(spaced_route(figure_of_eight().select(slice(0, 1))))
    corners: Any = map_chart(hover).select_one({"name": "corners"})
    assert corners.data_source.data["x"].tolist() == pytest.approx([-2.5, 2.5], abs=0.01)
    assert corners.data_source.data["y"].tolist() == pytest.approx([-2.5, 2.5], abs=0.01)
    assert corners.glyph.fill_alpha == corners.glyph.line_alpha == 0.0
    whole = replay_series(*made_replay())
    low, high = whole.recording.north_east_m.min(axis=0), whole.recording.north_east_m.max(axis=0)
    assert (whole.map_corners_m >= low).all() and (whole.map_corners_m <= high).all()


def test_a_plan_is_drawn_as_it_is_predicted_to_fly() -> None:
    """What was flown takes its place."""
    route, outcome = made_replay()
    route = with_prediction(route, 30.0)
    for series, shown in ((replay_series(route), True), (replay_series(route, outcome), False)):
        legend: Any = map_chart(series).legend[0]
        assert ("predicted" in [item.label.value for item in legend.items]) == shown


def test_waypoint_numbers_do_not_overlap() -> None:
    """They keep a share of the map between them; the first waypoint always has its number."""
    series = replay_series(*made_replay())
    labelled = label_indices(series.waypoints_m)
    assert labelled[0] == 0
    points_m = series.waypoints_m[labelled]
    gaps = np.linalg.norm(points_m[:, None] - points_m[None], axis=2)[np.triu_indices(len(points_m), 1)]
    assert gaps.min() >= LABEL_GAP_SHARE * np.ptp(series.waypoints_m, axis=0).max()
    assert label_indices(np.zeros((3, 2))) == [0]
    drawn: list[Any] = map_chart(series).renderers
    assert sum(isinstance(each.glyph, Text) for each in drawn) == 2  # And that of home.
    assert len(labelled) > 4


def test_waypoints_are_counted_as_waypoints() -> None:
    """Speed changes are items too, which the display and the readings do not count."""
    series = replay_series(spaced_route(figure_of_eight(), spacing_m=6.0, max_points=60, speed_m_s=3.0))
    drawn: list[Any] = map_chart(series).renderers
    texts = [each for each in drawn if isinstance(each.glyph, Text)]
    assert series.waypoint_seqs[0] == 3
    assert texts[0].data_source.data["text"][0] == "1"


def test_left_of_a_path_to_the_north_is_west() -> None:
    """Left of a path that does not move is north."""
    assert left_of_path(np.array([[0.0, 0.0], [5.0, 0.0]])).tolist() == [[0, -1], [0, -1]]
    assert left_of_path(np.zeros((1, 2))).tolist() == [[1, 0]]


def test_charts_over_time_zoom_together() -> None:
    """They share a range; errors start at 0."""
    first: Any = time_chart("path error", "time (s)", "error (m)")
    second = time_chart("ground speed", "time (s)", "speed (m/s)", x_range=first.x_range)
    assert second.x_range is first.x_range
    assert first.y_range.start == 0
    add_line(first, [0.0, 1.0], np.array([2.0, 3.0]), "recorded")
    assert first.renderers[0].glyph.line_color == RECORDED_COLOUR


def test_a_single_value_over_time_is_a_dot() -> None:
    """It makes no line."""
    chart: Any = time_chart("position error", "time (s)", "error (m)")
    add_line(chart, np.array([1.0]), np.array([2.0]), "predicted")
    (dot,) = chart.renderers
    assert isinstance(dot.glyph, Scatter)
    assert (dot.glyph.line_color, dot.name) == (PREDICTED_COLOUR, "predicted")


@pytest.mark.parametrize("name", ["recorded, not covered", "recorded", "planned", "flown"])
def test_the_tooltip_of_a_line_shows_its_values(name: str) -> None:
    """It has the line's name, the value and the time."""
    chart = time_chart("ground speed", "time (s)", "speed (m/s)")
    add_line(chart, [0.0, 1.0], np.array([2.0, 3.0]), name)
    assert chart.hover[0].tooltips == f"{name} @y{{0.00}} at @x{{0.0}} s"
