"""Why flights end early, in words."""

from __future__ import annotations

from flight_replay.supervisor import flight_ended


def test_an_early_end_reads_as_its_problem() -> None:
    """In a log of errors too."""
    end = flight_ended.rebooted()
    assert str(end) == end.problem == "the autopilot rebooted; find out why before flying again"


def test_a_failsafe_that_brakes_asks_for_somebody_to_take_control() -> None:
    """Of all that it may choose this is what never lands by itself."""
    assert flight_ended.failsafe("BRAKE", "Fence Breached").problem.endswith(
        "take control, the vehicle hovers there"
    )


def test_a_vehicle_that_cannot_be_armed_yet_has_no_failsafe_to_watch() -> None:
    """Its link is lost on the ground."""
    problem = flight_ended.link_lost("no data for 30 s", may_be_armed=False).problem
    assert problem == "link to the vehicle lost: no data for 30 s; check the link"
    assert "its own failsafe takes over: watch it" in flight_ended.link_lost("no data for 30 s").problem
