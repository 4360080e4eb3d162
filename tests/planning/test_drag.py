"""Drag from the vehicle's own parameters, or that of SITL's quadcopter."""

from __future__ import annotations

import numpy as np
import pytest

from flight_replay.planning.drag import DragModel, drag_model_of, sitl_drag
from flight_replay.planning.following.followed_route import FollowOptions, followed_route
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.made_replays import figure_of_eight

SITL_SUGGESTS = {"EK3_DRAG_BCOEF_X": 17.209, "EK3_DRAG_BCOEF_Y": 17.209, "EK3_DRAG_MCOEF": 0.209}
"""What ArduCopter 4.6's SITL prints for its own quadcopter as it starts."""


@pytest.mark.parametrize("amsl_m", [0.0, 600.0, 2000.0])
def test_parameters_that_sitl_suggests_give_its_drag(amsl_m: float) -> None:
    """The square part exactly; for the linear part SITL takes the thrust of a leaning copter."""
    model = drag_model_of(SITL_SUGGESTS)
    assert model is not None
    drag, sitl = model.at(amsl_m), sitl_drag(amsl_m)
    assert drag.square_per_m == pytest.approx(sitl.square_per_m, rel=1e-4)
    assert drag.linear_per_s == pytest.approx(sitl.linear_per_s, rel=0.2)


@pytest.mark.parametrize(
    "unset", [{}, {"EK3_DRAG_BCOEF_X": 0.0, "EK3_DRAG_BCOEF_Y": 0.0, "EK3_DRAG_MCOEF": 0.0}]
)
def test_parameters_that_are_not_set_tell_nothing(unset: dict[str, float]) -> None:
    assert drag_model_of(unset) is None


def test_the_axis_with_more_drag_counts() -> None:
    """A low ratio of mass to area is much drag."""
    assert drag_model_of({"EK3_DRAG_BCOEF_X": 20.0, "EK3_DRAG_BCOEF_Y": 10.0}) == DragModel(10.0, 0.0)
    assert drag_model_of({"EK3_DRAG_MCOEF": 0.3}) == DragModel(None, 0.3)
    assert DragModel(None, 0.3).at(0.0).square_per_m == 0.0


def test_a_vehicle_with_more_drag_is_planned_slower_where_it_flies_fast() -> None:
    """Its lean is used up by drag sooner."""
    track = figure_of_eight()
    tops_m_s = []
    for drag in (None, DragModel(2.0, 1.0)):
        reference = followed_route(track, track.alt_m, Limits(), FollowOptions(pace=4.0, drag=drag)).reference
        assert reference is not None
        velocity = reference.velocities_m_s(reference.times_s(0.1))
        tops_m_s.append(np.hypot(*velocity[:, :2].T).max())
    assert tops_m_s[1] < 0.8 * tops_m_s[0]
