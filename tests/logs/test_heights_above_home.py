"""Heights above home of tracks that have heights above the sea."""

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats
from flight_replay.logs.heights_above_home import with_heights_above_home
from flight_replay.logs.track import track_from_columns

AT: Floats = np.arange(60.0)


def heights_m(amsl_m: Floats, home_amsl_m: float, *, still: int = 20) -> Floats:
    """Heights above home (60,) of a track that stands still for some fixes, and moves on from there."""
    velocity_m_s = np.zeros((60, 3))
    velocity_m_s[still:, 0] = 5.0
    track = track_from_columns(
        AT, 47.0 + AT * 1e-5, np.full(60, 8.0), np.full(60, np.nan), amsl_m=amsl_m, velocity_m_s=velocity_m_s
    )
    return with_heights_above_home(track, home_amsl_m).alt_m


def test_without_a_home_heights_count_from_the_first_fix_that_moves() -> None:
    """Whatever was ahead of it."""
    assert heights_m(400.0 + AT, np.nan) == pytest.approx(AT - 20.0)


@pytest.mark.parametrize("still", [0, 20])
def test_a_track_that_begins_above_home_is_above_that(still: int) -> None:
    """It is a part of a flight, which may begin with a hover."""
    assert heights_m(412.0 + AT, 400.0, still=still) == pytest.approx(AT + 12.0)


def test_a_track_that_begins_at_home_began_on_the_ground() -> None:
    """Perhaps at the foot of the hill where it was flown after another start of the autopilot."""
    amsl_m = np.where(AT < 20, 400.0, 600.0 + AT)
    assert heights_m(amsl_m, 400.5)[20:] == pytest.approx(AT[20:] - 20.0)


def test_a_home_that_was_not_set_does_not_count() -> None:
    """Its height is 0 then."""
    assert heights_m(400.0 + AT, 0.0) == pytest.approx(AT - 20.0)
