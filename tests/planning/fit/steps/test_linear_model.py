"""The changes that make linear errors small: bounded, and none where last bits are all there is."""

import numpy as np
import pytest

from flight_replay.planning.fit.steps.linear_model import LinearModel


@pytest.mark.parametrize("both_sides", [False, True])
def test_what_last_bits_leave_of_no_change_is_none(both_sides: bool) -> None:
    """They differ from processor to processor, and a change of any size may be to blame for a delay."""
    for bits in (-3e-16, 0.0, 2e-16):
        force = np.array([-0.5, bits, bits, 0.8])
        forces = np.append(force, -force) if both_sides else force
        model = LinearModel(np.eye(len(forces)), forces, both_sides)
        assert model.best_changes(1e-6, np.ones(4)).tolist() == [0.5, 0.0, 0.0, -0.8]


def test_changes_are_at_most_twice_the_usual() -> None:
    """A step that is linear about a draft says nothing of one that is far from it."""
    model = LinearModel(np.eye(2), np.array([-5.0, 5.0]), both_sides=False)
    assert model.best_changes(0.0, np.array([0.1, 0.4])).tolist() == [0.2, -0.8]
