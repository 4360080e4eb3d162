"""events.py: listeners are combined."""

import logging

import pytest

from flight_replay.events import Event, Finished, combine_listeners


def test_a_listener_that_fails_does_not_stop_the_others(caplog: pytest.LogCaptureFixture) -> None:
    """Its exception is logged; the other listeners get the event."""
    received: list[Event] = []

    def failing(event: Event) -> None:
        raise RuntimeError("no screen")

    with caplog.at_level(logging.ERROR):
        combine_listeners(failing, received.append)(Finished("duration"))
    assert received == [Finished("duration")]
    assert "a listener failed" in caplog.text
