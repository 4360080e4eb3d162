"""charts.py: Bokeh charts of a replay."""

from typing import Any

import numpy as np
import pytest
from bokeh.models import Text

from flight_replay.output.charts.bokeh_charts import (
    LABEL_SHARE,
    add_line,
    apart,
    beside,
    map_chart,
    time_chart,
)
from flight_replay.output.charts.series import RECORDED, curves
from tests.helpers.made_replays import replay


def test_the_map_is_to_scale_and_labelled_with_units() -> None:
    """A metre is as long up as across; both axes say what they are."""
    chart = map_chart(curves(*replay()))
    assert chart.match_aspect
    assert chart.xaxis[0].axis_label == "east of the first fix (m)"
    assert chart.yaxis[0].axis_label == "north of the first fix (m)"
    legend: Any = chart.legend[0]
    assert [item.label.value for item in legend.items] == ["recorded", "planned", "waypoints"]


def test_numbers_of_waypoints_do_not_cover_each_other() -> None:
    """Numbers stand apart by a share of the map; the first is always there, places on one spot show one."""
    shown = curves(*replay())
    named = apart(shown.waypoints_m)
    assert named[0] == 0
    places = shown.waypoints_m[named]
    gaps = np.linalg.norm(places[:, None] - places[None], axis=2)[np.triu_indices(len(places), 1)]
    assert gaps.min() >= LABEL_SHARE * np.ptp(shown.waypoints_m, axis=0).max()
    assert apart(np.zeros((3, 2))) == [0]
    drawn: list[Any] = map_chart(shown).renderers
    assert sum(isinstance(each.glyph, Text) for each in drawn) == 1
    assert len(named) > 5


def test_numbers_stand_to_the_left_of_the_way() -> None:
    """Flying north, left is west; a vehicle that stays where it is has its number north of it."""
    assert beside(np.array([[0.0, 0.0], [5.0, 0.0]])).tolist() == [[0, -1], [0, -1]]
    assert beside(np.zeros((1, 2))).tolist() == [[1, 0]]


def test_charts_over_time_share_their_zoom() -> None:
    """A range that is handed on is used; distances start at nought."""
    first: Any = time_chart("distance in space", "distance (m)")
    second = time_chart("ground speed", "speed (m/s)", x_range=first.x_range)
    assert second.x_range is first.x_range
    assert first.y_range.start == 0
    add_line(first, [0.0, 1.0], np.array([2.0, 3.0]), "recorded")
    assert first.renderers[0].glyph.line_color == RECORDED


@pytest.mark.parametrize("name", ["recorded", "planned", "flown"])
def test_hovering_over_a_line_tells_its_values(name: str) -> None:
    """The tip names the line and gives value and time."""
    chart = time_chart("ground speed", "speed (m/s)")
    add_line(chart, [0.0, 1.0], np.array([2.0, 3.0]), name)
    assert chart.hover[0].tooltips == f"{name} @y{{0.00}} at @x{{0.0}} s"
