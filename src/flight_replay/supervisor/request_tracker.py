"""What is known of the requests sent to the vehicle: accepted, refused or lost."""

from __future__ import annotations

from flight_replay.supervisor.vehicle_interface import Request, RequestAck


class RequestTracker:
    """The latest ack of each request, and the requests that are known to have failed."""

    def __init__(self) -> None:
        self.acks: dict[Request, RequestAck] = {}
        self._lost: set[Request] = set()
        self._failed: set[Request] = set()
        self.told_of_disarming = False
        """Whether a status text did since; no heartbeat need have shown the vehicle armed before."""

    def clear(self) -> None:
        """Forget all acks and failures: a new phase begins."""
        self.acks.clear()
        self.told_of_disarming = False
        self.sending()

    def sending(self) -> None:
        """A request is sent now: an earlier failure says nothing about it."""
        self._lost.clear()
        self._failed.clear()

    def acked(self, ack: RequestAck) -> None:
        """The vehicle accepted or refused a request."""
        self.acks[ack.request] = ack
        if not ack.accepted:
            self._failed.add(ack.request)

    def lost(self, request: Request) -> None:
        """A request or its ack is lost; the next heartbeat shows which of the two."""
        self._lost.add(request)

    def heartbeat(self) -> None:
        """A heartbeat came: a lost request that it does not show as done has failed."""
        self._failed |= self._lost

    def failed(self, request: Request) -> bool:
        """Whether the last request was refused, or lost on the way."""
        return request in self._failed

    def accepted(self, request: Request) -> bool:
        """Whether the vehicle accepted the last request."""
        ack = self.acks.get(request)
        return ack is not None and ack.accepted
