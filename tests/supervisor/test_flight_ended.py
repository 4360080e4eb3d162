"""Why flights end early, in words."""

from __future__ import annotations

from flight_replay.supervisor import flight_ended


def test_an_early_end_reads_as_its_problem() -> None:
    """In a log of errors too."""
    end = flight_ended.rebooted()
    assert str(end) == end.problem == "the autopilot rebooted; find out why before flying again"
