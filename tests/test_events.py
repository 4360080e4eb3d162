"""events.py: listeners are combined, and may join later."""

import logging

import pytest

from flight_replay.events import Event, Finished, Relay, combine_listeners


def test_a_listener_that_fails_does_not_stop_the_others(caplog: pytest.LogCaptureFixture) -> None:
    """Its exception is logged; the other listeners get the event."""
    received: list[Event] = []

    def failing(event: Event) -> None:
        raise RuntimeError("no screen")

    with caplog.at_level(logging.ERROR):
        combine_listeners(failing, received.append)(Finished("duration"))
    assert received == [Finished("duration")]
    assert "a listener failed" in caplog.text


def test_a_relay_passes_events_on_to_its_target_of_now() -> None:
    """What was emitted before goes to the target of then."""
    before, after = list[Event](), list[Event]()
    relay = Relay(before.append)
    relay(Finished("one"))
    relay.target = combine_listeners(relay.target, after.append)
    relay(Finished("two"))
    assert (before, after) == ([Finished("one"), Finished("two")], [Finished("two")])
