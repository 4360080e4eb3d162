"""A lost link is emitted once, its return too, and a long silence ends the flight."""

from __future__ import annotations

import pytest

from flight_replay.events import Event, LinkLost, LinkRestored
from flight_replay.supervisor import Deadlines
from flight_replay.supervisor.link_monitor import LinkMonitor
from tests.helpers.fake_vehicle import FakeClock

DEADLINES = Deadlines(link_lost_wall_s=4.0, give_up_wall_s=30.0)


class Silence:
    """A link to which nobody sends, looked at ten times a second."""

    def __init__(self) -> None:
        self.clock, self.events = FakeClock(), list[Event]()
        self.link = LinkMonitor(self.clock, DEADLINES)

    def lasts(self, seconds: float) -> bool:
        """Whether the flight ends by it."""
        ends = False
        for _ in range(round(10 * seconds)):
            self.clock.now_s = round(self.clock.now_s + 0.1, 3)
            ends = self.link.check(self.events.append)
        return ends

    def ends(self) -> None:
        """Data comes."""
        self.link.received(self.events.append)


def test_a_silent_link_is_lost_and_then_ends_the_flight() -> None:
    """Lost at 4 s, emitted once; the flight ends at 30 s; both limits included."""
    silence = Silence()
    for further_s, lost, end in ((3.9, 0, False), (0.1, 1, False), (25.9, 1, False), (0.1, 1, True)):
        assert silence.lasts(further_s) is end
        assert len(silence.events) == lost
    assert silence.events == [LinkLost(4.0)]


def test_a_restored_link_is_emitted_once() -> None:
    """``LinkRestored`` follows a ``LinkLost`` only, and silence is measured again from then on."""
    silence = Silence()
    silence.lasts(3.0)
    silence.ends()
    silence.lasts(3.0)
    assert silence.events == []
    silence.lasts(4.0)
    silence.ends()
    silence.ends()
    assert silence.events == [LinkLost(4.0), LinkRestored(7.0)]
    silence.lasts(4.5)
    assert silence.events[2:] == [LinkLost(4.0)]


def test_the_silence_is_a_phrase_for_messages() -> None:
    """Whole seconds while the link is lost, empty while it is up."""
    silence = Silence()
    silence.lasts(3.0)
    assert silence.link.silence == ""
    silence.lasts(4.2)
    assert silence.link.silence == "no data for 7 s"
    silence.ends()
    assert silence.link.silence == ""


def test_a_program_that_was_stopped_has_not_lost_the_link() -> None:
    """What came meanwhile is not processed yet; a silence from then on counts, and one of before."""
    silence = Silence()
    silence.lasts(2.0)
    silence.clock.now_s += 40.0
    assert not silence.lasts(0.9)
    assert silence.events == []
    silence.lasts(1.2)
    assert [type(event) for event in silence.events] == [LinkLost]
    assert silence.link.silence == "no data for 5 s"


@pytest.mark.parametrize("field", ["link_lost_wall_s", "give_up_wall_s"])
def test_a_link_is_not_lost_at_the_start(field: str) -> None:
    """Silence is measured from the start of the flight."""
    assert not LinkMonitor(FakeClock(), Deadlines(**{field: 0.1})).check(
        lambda event: pytest.fail(str(event))
    )
