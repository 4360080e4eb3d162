"""Downloads a mission or fence with several requests in flight: they do not depend on each other."""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice

from flight_replay.exceptions import VehicleError
from flight_replay.mavlink import MISSION_RESULTS, Message, dialect
from flight_replay.mission.items import MissionItem
from flight_replay.vehicle.link import timesync
from flight_replay.vehicle.link.vehicle_link import Inbox, VehicleLink
from flight_replay.vehicle.protocol.mission_items import item_from

_NO_PROGRESS_S = 12.0  # Longer than the 8 s after which ArduPilot ends another station's upload.
_BUSY_S = 0.5
_MAX_WAIT_S = 0.2  # No wait is longer than this without a call of ``while_waiting``.
MISSION = int(dialect.MAV_MISSION_TYPE_MISSION)
FENCE = int(dialect.MAV_MISSION_TYPE_FENCE)


class MissionDownloader:
    """One download of the list of ``mission_type``; a mission includes home, item 0.

    ``while_waiting`` is called repeatedly, for a caller that has to watch the vehicle meanwhile.
    """

    def __init__(
        self,
        link: VehicleLink,
        *,
        as_int: bool,
        mission_type: int = MISSION,
        while_waiting: Callable[[], None] = lambda: None,
    ) -> None:
        self._type, self._while_waiting = mission_type, while_waiting
        self._list = "fence" if mission_type == FENCE else "mission"
        self._link, self._round_trip, self._as_int = link, link.round_trip, as_int
        self._items: dict[int, MissionItem] = {}
        self._requested_s: dict[int, float] = {}
        self._first_requested_s: dict[int, float] = {}
        self._unanswered: dict[int, None] = {}  # In ascending order, and no more than were ever in a window.
        self._unrequested = 0  # The first item never requested.

    def run(self) -> list[MissionItem]:
        """All items, home first; empty if the vehicle has none.

        Raises:
            VehicleError: The vehicle does not answer, or refuses.
        """
        types = ("MISSION_COUNT", "MISSION_ITEM_INT", "MISSION_ITEM", "MISSION_ACK")
        with self._link.inbox(*types) as inbox:
            count = self._request_count(inbox)
            self._request_items(inbox, count)
        self._link.send(
            dialect.MAVLink_mission_ack_message(
                self._link.system, self._link.component, dialect.MAV_MISSION_ACCEPTED, self._type
            )
        )
        return [self._items[seq] for seq in range(count)]

    def _request_count(self, inbox: Inbox) -> int:
        link, end_s = self._link, self._link.now_s() + _NO_PROGRESS_S
        reason = "no answer"
        while link.now_s() < end_s:
            link.send(dialect.MAVLink_mission_request_list_message(link.system, link.component, self._type))
            requested_s = link.now_s()
            while (message := self._next(inbox, requested_s + self._round_trip.retry_s)) is not None:
                if message.get_type() == "MISSION_COUNT" and self._has_our_type(message):
                    self._round_trip.measured(link.now_s() - requested_s)
                    return int(message.count)
                if message.get_type() == "MISSION_ACK" and message.type != dialect.MAV_MISSION_ACCEPTED:
                    reason = f"the vehicle answers {MISSION_RESULTS.get(message.type, message.type)}"
                    inbox.get(_BUSY_S)
            self._round_trip.lost()
            timesync.ping(link)
        raise VehicleError(
            f"cannot download the {self._list} in {_NO_PROGRESS_S:.0f} s: {reason}; check the link"
        )

    def _next(self, inbox: Inbox, until_s: float) -> Message | None:
        """The next message, calling ``while_waiting`` until it comes; None if none comes by then."""
        while True:
            self._while_waiting()
            left_s = until_s - self._link.now_s()
            message = inbox.get(min(left_s, _MAX_WAIT_S))
            if message is not None or left_s <= _MAX_WAIT_S:
                return message

    def _request_items(self, inbox: Inbox, count: int) -> None:
        progress_s = self._link.now_s()
        while len(self._items) < count:
            if self._link.now_s() - progress_s > _NO_PROGRESS_S:
                missing = self._first_missing(count, 1)[0]
                raise VehicleError(
                    f"cannot download {self._list} item {missing}: no answer in {_NO_PROGRESS_S:.0f} s; "
                    "check the link"
                )
            self._request_missing(count)
            message = self._next(inbox, self._link.now_s() + self._round_trip.retry_s / 4)
            while message is not None:
                if self._take(message, count):
                    progress_s = self._link.now_s()
                    self._request_missing(count)
                message = inbox.get(0.0)

    def _request_missing(self, count: int) -> None:
        """Keep a window of requests in flight, and repeat those that are overdue."""
        now_s = self._link.now_s()
        for seq in self._first_missing(count, self._round_trip.window):
            if now_s - self._requested_s.get(seq, float("-inf")) < self._round_trip.retry_s:
                continue
            if seq in self._requested_s:
                self._round_trip.lost()
                timesync.ping(self._link)
                if not self._as_int:  # The vehicle may know MISSION_REQUEST_INT after all.
                    self._request(seq, as_int=True)
            self._requested_s[seq] = now_s
            self._first_requested_s.setdefault(seq, now_s)
            self._request(seq, as_int=self._as_int)

    def _first_missing(self, count: int, limit: int) -> list[int]:
        """The first items that are missing, in a time that does not depend on ``count``."""
        while len(self._unanswered) < limit and self._unrequested < count:
            self._unanswered[self._unrequested] = None
            self._unrequested += 1
        return list(islice(self._unanswered, limit))

    def _request(self, seq: int, *, as_int: bool) -> None:
        link = self._link
        message_class = (
            dialect.MAVLink_mission_request_int_message if as_int else dialect.MAVLink_mission_request_message
        )
        link.send(message_class(link.system, link.component, seq, self._type))

    def _take(self, message: Message, count: int) -> bool:
        """Whether the message is an item that was missing."""
        kind = message.get_type()
        wanted = ("MISSION_ITEM_INT",) if self._as_int else ("MISSION_ITEM", "MISSION_ITEM_INT")
        if kind not in wanted or not self._has_our_type(message) or message.seq >= count:
            return False
        if message.seq in self._items or message.seq not in self._requested_s:
            return False
        if self._requested_s[message.seq] == self._first_requested_s[message.seq]:  # Karn's rule.
            self._round_trip.measured(self._link.now_s() - self._requested_s[message.seq])
        self._items[message.seq] = item_from(message)
        del self._unanswered[message.seq]
        return True

    def _has_our_type(self, message: Message) -> bool:
        """Whether a message is about the list that is being downloaded."""
        return bool(getattr(message, "mission_type", MISSION) == self._type)
