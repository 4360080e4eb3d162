"""json_summary.py: the objects of ``--json``."""

from dataclasses import replace

from flight_replay.output.json_summary import flight_summary, route_summary
from tests.helpers.made_replays import made_replay


def test_items_are_numbered_from_1_without_home() -> None:
    """Sequence numbers are those on board, where home is item 0."""
    route, _, _ = made_replay()
    summary = route_summary(route)
    count = len(route.mission.items)
    assert [item["seq"] for item in summary["items"]] == list(range(1, count + 1))
    assert (summary["method"], summary["points"]) == ("spacing", count)


def test_errors_that_do_not_exist_are_null() -> None:
    """A flight that reached no waypoint has no position error; its keys stay."""
    _, record, outcome = made_replay()
    nothing = replace(outcome, position_error=None)
    summary = flight_summary("ArduCopter V4.6.0", True, record, nothing)
    assert summary["distance_in_time_m"] == {"mean": None, "p95": None, "max": None}
    assert summary["distance_in_space_m"]["max"] > 0
    assert (summary["vehicle"], summary["simulated"], summary["ended"]) == (
        "ArduCopter V4.6.0",
        True,
        "duration",
    )
