"""Recorded altitudes: which are plausible, and none too low."""

from dataclasses import replace

import numpy as np

from flight_replay.planning.altitude import MIN_ALTITUDE_M, plausible_altitudes_m
from tests.helpers.fit_tracks import (
    along,
)


def test_heights_before_home_was_set_are_not_believed() -> None:
    """Heights of 580 m that come from home not being set yet are replaced by the first believable one."""
    track = along([(0, 0), (30, 0)], 3.0)
    heights = np.full(len(track), 12.0)
    heights[:5] = 412.0
    heights[-1] = -1.0
    strange = replace(track, alt_m=heights, amsl_m=np.full(len(track), 412.0))
    assert plausible_altitudes_m(strange)[:6].tolist() == [12.0] * 6
    strange = replace(track, alt_m=np.full(len(track), np.nan))
    assert (plausible_altitudes_m(strange) == MIN_ALTITUDE_M).all()
