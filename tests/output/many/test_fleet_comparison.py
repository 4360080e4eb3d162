"""Comparing two tables: what is worse, what is better, what is no change."""

from __future__ import annotations

import pytest

from flight_replay.exceptions import FlightReplayError
from flight_replay.output.many.fleet_comparison import Tolerance, compare_tables, comparison_lines
from flight_replay.output.many.flight_columns import Row


def row(flight: int = 1, **more: object) -> Row:
    return {
        "log": "a.tlog", "log_sha256": "aa", "flight": flight, "status": "flown", "flown_by": "sitl",
        "ended": "duration", "waypoints": 9, "waypoints_reached": 9, "options_id": "x",
        "flown_position_mean_m": 1.0, "flown_heading_p95_deg": 10.0, **more,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("changed", "worse", "better"),
    [
        ({}, 0, 0),
        ({"flown_position_mean_m": 1.19, "flown_heading_p95_deg": 11.9}, 0, 0),
        ({"flown_position_mean_m": 1.21}, 1, 0),
        ({"flown_heading_p95_deg": 12.1}, 1, 0),
        ({"flown_position_mean_m": 0.7}, 0, 1),
        ({"waypoints_reached": 8}, 1, 0),
        ({"status": "failed", "problem": "it crashed", "flown_position_mean_m": 0.1}, 1, 0),
        ({"status": "worker lost"}, 1, 0),
    ],
)
def test_a_change_beyond_the_tolerance_counts(changed: dict[str, object], worse: int, better: int) -> None:
    comparison = compare_tables([row(), row(2)], [{**row(), **changed}, row(2)], Tolerance(0.2, 0.1))
    assert (len(comparison.worse), len(comparison.better)) == (worse, better)
    assert f"{worse} became worse" in comparison_lines(comparison)[0]


def test_what_failed_before_and_flies_now_is_better() -> None:
    comparison = compare_tables([row(status="failed", problem="x")], [row()], Tolerance())
    assert [each.worse for each in comparison.changes] == [False]


def test_a_motion_that_was_followed_has_no_waypoints_to_tell() -> None:
    """How it ended says what changed."""
    followed = row(waypoints=0, waypoints_reached=0)
    (change,) = compare_tables([followed], [{**followed, "ended": "recording complete"}], Tolerance()).changes
    assert change.text == "duration, now recording complete"


def test_a_missing_flight_is_worse_and_a_new_one_is_told() -> None:
    comparison = compare_tables([row(), row(2)], [row(), row(3)], Tolerance())
    assert ["missing" in each.text for each in comparison.worse] == [True]
    assert comparison.only_new == 1


def test_tables_without_a_common_flight_are_refused() -> None:
    with pytest.raises(FlightReplayError, match="in common"):
        compare_tables([row()], [row(2)], Tolerance())
    with pytest.raises(FlightReplayError, match="several sets of options"):
        compare_tables([row(), row(options_id="y")], [row()], Tolerance())
