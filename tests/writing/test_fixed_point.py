"""fixed_point.py: numbers with so many decimals."""

import pytest

from flight_replay.writing.fixed_point import fixed_point


@pytest.mark.parametrize(
    ("value", "decimals", "text"),
    [(12.0, 1, "12.0"), (-0.04, 1, "0.0"), (-0.0, 2, "0.00"), (-0.06, 1, "-0.1"), (-4e-8, 7, "0.0000000")],
)
def test_nothing_is_not_negative(value: float, decimals: int, text: str) -> None:
    assert fixed_point(value, decimals) == text
