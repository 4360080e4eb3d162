"""MAVLink messages out of the bytes of several senders, whose frames must not mix."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable, Iterator
from typing import Any

from flight_replay.mavlink import Message, parsed, robust_parser

MAX_SENDERS = 16


class ParserPool:
    """A parser for each sender; of more than ``MAX_SENDERS``, the ones longest silent are forgotten."""

    def __init__(self) -> None:
        self._parsers: OrderedDict[Hashable, Any] = OrderedDict()

    def messages(self, data: bytes, sender: Hashable) -> Iterator[Message]:
        """The messages that ``data`` completes; bytes that are no message are skipped."""
        if not data:
            return
        try:
            messages = parsed(self._parser(sender), data)
        except Exception:
            self._parsers.pop(sender, None)  # What it holds would fail again and again.
            raise
        for message in messages:
            if message.get_type() != "BAD_DATA":
                yield message

    def _parser(self, sender: Hashable) -> Any:
        if sender not in self._parsers:
            self._parsers[sender] = robust_parser()
            if len(self._parsers) > MAX_SENDERS:
                self._parsers.popitem(last=False)
        self._parsers.move_to_end(sender)
        return self._parsers[sender]

    def clear(self) -> None:
        """Forget what was begun: the connection was opened anew."""
        self._parsers.clear()
