"""Acks and losses of requests."""

from __future__ import annotations

from flight_replay.supervisor.request_tracker import RequestTracker
from flight_replay.supervisor.vehicle_interface import Request, RequestAck

REFUSED = RequestAck(Request.ARM, False, "failed")
ACCEPTED = RequestAck(Request.ARM, True)


def test_nothing_is_known_before_an_ack() -> None:
    """A request without an ack has neither failed nor been accepted."""
    requests = RequestTracker()
    assert not requests.failed(Request.ARM)
    assert not requests.accepted(Request.ARM)


def test_an_accepted_request_has_not_failed() -> None:
    """The latest ack counts, and only for its own request."""
    requests = RequestTracker()
    requests.acked(ACCEPTED)
    assert requests.accepted(Request.ARM)
    assert not requests.failed(Request.ARM)
    assert not requests.accepted(Request.MODE)
    assert requests.acks == {Request.ARM: ACCEPTED}


def test_a_refused_request_has_failed() -> None:
    """Only the request that was refused."""
    requests = RequestTracker()
    requests.acked(REFUSED)
    assert requests.failed(Request.ARM)
    assert not requests.accepted(Request.ARM)
    assert not requests.failed(Request.MODE)


def test_a_lost_request_fails_with_the_next_heartbeat() -> None:
    """Until then the vehicle may have received it, and only its ack be lost."""
    requests = RequestTracker()
    requests.lost(Request.MODE)
    assert not requests.failed(Request.MODE)
    requests.heartbeat()
    assert requests.failed(Request.MODE)
    assert not requests.failed(Request.ARM)


def test_sending_again_forgets_failures_but_not_acks() -> None:
    """A refusal or loss of an earlier request says nothing about the next one."""
    requests = RequestTracker()
    requests.acked(REFUSED)
    requests.lost(Request.MODE)
    requests.sending()
    requests.heartbeat()
    assert not requests.failed(Request.ARM)
    assert not requests.failed(Request.MODE)
    assert requests.acks == {Request.ARM: REFUSED}


def test_a_new_phase_forgets_everything() -> None:
    """Neither acks nor failures nor losses outlive a phase."""
    requests = RequestTracker()
    requests.acked(REFUSED)
    requests.lost(Request.MODE)
    requests.clear()
    requests.heartbeat()
    assert requests.acks == {}
    assert not requests.failed(Request.ARM)
    assert not requests.failed(Request.MODE)
