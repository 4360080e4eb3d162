"""A lost link is emitted once, its return too, and a long silence ends the flight."""

from __future__ import annotations

import pytest

from flight_replay.events import Event, LinkLost, LinkRestored
from flight_replay.supervisor import Deadlines
from flight_replay.supervisor.link_monitor import LinkMonitor
from tests.helpers.fake_vehicle import FakeClock

DEADLINES = Deadlines(link_lost_wall_s=4.0, give_up_wall_s=30.0)


def test_a_silent_link_is_lost_and_then_ends_the_flight() -> None:
    """Lost at 4 s, emitted once; the flight ends at 30 s; both limits included."""
    clock, events = FakeClock(), list[Event]()
    link = LinkMonitor(clock, DEADLINES)
    began_s = clock.now_s
    for silent_s, lost, end in ((3.9, 0, False), (4.0, 1, False), (29.9, 1, False), (30.0, 1, True)):
        clock.now_s = began_s + silent_s
        assert link.check(events.append) is end
        assert len(events) == lost
    assert events == [LinkLost(4.0)]


def test_a_restored_link_is_emitted_once() -> None:
    """``LinkRestored`` follows a ``LinkLost`` only, and silence is measured again from then on."""
    clock, events = FakeClock(), list[Event]()
    link = LinkMonitor(clock, DEADLINES)
    clock.now_s += 3.0
    link.received(events.append)
    clock.now_s += 3.0
    assert not link.check(events.append)
    assert events == []
    clock.now_s += 4.0
    link.check(events.append)
    clock.now_s += 5.0
    link.received(events.append)
    link.received(events.append)
    assert events == [LinkLost(7.0), LinkRestored(12.0)]
    clock.now_s += 4.5
    link.check(events.append)
    assert events[2:] == [LinkLost(4.5)]


def test_the_silence_is_a_phrase_for_messages() -> None:
    """Whole seconds while the link is lost, empty while it is up."""
    clock = FakeClock()
    link = LinkMonitor(clock, DEADLINES)
    clock.now_s += 3.0
    link.check(lambda event: None)
    assert link.silence == ""
    clock.now_s += 4.2
    link.check(lambda event: None)
    assert link.silence == "no data for 7 s"
    link.received(lambda event: None)
    assert link.silence == ""


@pytest.mark.parametrize("field", ["link_lost_wall_s", "give_up_wall_s"])
def test_a_link_is_not_lost_at_the_start(field: str) -> None:
    """Silence is measured from the start of the flight."""
    assert not LinkMonitor(FakeClock(), Deadlines(**{field: 0.1})).check(
        lambda event: pytest.fail(str(event))
    )
