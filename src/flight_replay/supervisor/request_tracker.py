"""What came of what was asked of the vehicle."""

from __future__ import annotations

from flight_replay.supervisor.vehicle_interface import Answer, Request


class Requests:
    """The newest answers, and which requests are known to have come to nothing."""

    def __init__(self) -> None:
        self.answers: dict[Request, Answer] = {}
        self._unanswered: set[Request] = set()
        self._failed: set[Request] = set()

    def forget(self) -> None:
        """What comes from now on is about the step that begins now."""
        self.answers.clear()
        self.asking()

    def asking(self) -> None:
        """A request is sent now: that an earlier one failed says nothing of it."""
        self._unanswered.clear()
        self._failed.clear()

    def answer(self, answer: Answer) -> None:
        """The vehicle accepted or refused."""
        self.answers[answer.request] = answer
        if not answer.accepted:
            self._failed.add(answer.request)

    def unanswered(self, request: Request) -> None:
        """A request or its answer got lost; which of them, the next heartbeat will show."""
        self._unanswered.add(request)

    def beat(self) -> None:
        """A heartbeat came: what it does not show did not happen."""
        self._failed |= self._unanswered

    def failed(self, request: Request) -> bool:
        """Whether it is known that nothing came of the last request."""
        return request in self._failed

    def accepted(self, request: Request) -> bool:
        """Whether the vehicle said that it does what was asked."""
        answer = self.answers.get(request)
        return answer is not None and answer.accepted
