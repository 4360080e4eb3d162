"""Uploads and downloads repeat requests no sooner than needed: back-off, and Karn's rule for measuring."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from time import process_time
from typing import Any

import pytest

from flight_replay.exceptions import VehicleError
from flight_replay.mavlink import dialect
from flight_replay.mission.items import Home, Mission, waypoint
from flight_replay.simulator.autopilot.faults import old_copter
from flight_replay.vehicle.link.own_ids import OUR_COMPONENT, OUR_SYSTEM
from flight_replay.vehicle.link.round_trip import RoundTrip
from flight_replay.vehicle.protocol.mission_download import MissionDownloader
from flight_replay.vehicle.protocol.mission_items import item_message
from flight_replay.vehicle.protocol.mission_storage import MissionStorage
from flight_replay.vehicle.protocol.mission_upload import MissionUploader
from tests.helpers.link_conditions import LinkConditions
from tests.helpers.virtual_link import VirtualLink


class ScriptedLink:
    """A ``VehicleLink`` whose vehicle is a function: ``answers`` gives (delay, answer) for each message."""

    system, component = 1, 1

    def __init__(self, answers: Callable[[ScriptedLink, Any], list[tuple[float, Any]]]) -> None:
        self.round_trip = RoundTrip()
        self.round_trip.measured(0.2)
        self.sent: list[tuple[float, Any]] = []
        self._answers, self._coming, self._now_s = answers, list[tuple[float, Any]](), 0.0

    def now_s(self) -> float:
        return self._now_s

    def send(self, message: Any) -> None:
        self.sent.append((self._now_s, message))
        self._coming += [(self._now_s + delay_s, answer) for delay_s, answer in self._answers(self, message)]
        self._coming.sort(key=lambda item: item[0])

    @contextmanager
    def inbox(self, *types: str) -> Iterator[ScriptedLink]:
        yield self

    def get(self, timeout_s: float) -> Any:
        end_s = self._now_s + max(timeout_s, 0.0)
        if self._coming and self._coming[0][0] <= end_s:
            self._now_s, message = self._coming.pop(0)
            return message
        self._now_s = end_s
        return None

    def count(self, kind: str, seq: int | None = None) -> int:
        """How many messages of a type, or for an item, were sent."""
        return sum(m.get_type() == kind and (seq is None or m.seq == seq) for _, m in self.sent)


def request(seq: int) -> Any:
    return dialect.MAVLink_mission_request_int_message(OUR_SYSTEM, OUR_COMPONENT, seq)


def accepted() -> Any:
    return dialect.MAVLink_mission_ack_message(OUR_SYSTEM, OUR_COMPONENT, dialect.MAV_MISSION_ACCEPTED)


class ForgetfulLink(ScriptedLink):
    """A link that keeps no list of what was sent, which would take time by itself."""

    def send(self, message: Any) -> None:
        super().send(message)
        self.sent.clear()


MISSION = Mission(tuple(waypoint(47.0 + 1e-4 * i, 8.0, 30.0) for i in range(1, 101)))
ITEMS = [MISSION.with_home(Home(47.0, 8.0, 400.0)).home_item, *MISSION.items[:3]]


def test_an_answer_to_an_item_sent_twice_is_not_measured() -> None:
    """Karn's rule: it may be to the first one, and would make a slow link look fast."""

    def answers(link: ScriptedLink, message: Any) -> list[tuple[float, Any]]:
        if message.get_type() == "MISSION_COUNT":
            return [(0.2, request(0))]
        if message.get_type() == "MISSION_ITEM_INT" and link.count("MISSION_ITEM_INT", 0) == 2:
            # The answer to the first copy of item 0, right after the second one was sent.
            return [(0.001, request(1)), (0.002, accepted())] if message.seq == 0 else []
        return []

    link = ScriptedLink(answers)
    MissionUploader(link, ITEMS[:2], as_int=True).run(lambda taken: None)
    assert link.round_trip.median_s == 0.2


def test_an_answer_to_an_item_sent_once_is_measured() -> None:
    """The request for the next item follows from it."""

    def answers(link: ScriptedLink, message: Any) -> list[tuple[float, Any]]:
        if message.get_type() == "MISSION_COUNT":
            return [(0.2, request(0))]
        if message.get_type() == "MISSION_ITEM_INT":
            return [(0.1, accepted() if message.seq == 1 else request(message.seq + 1))]
        return []

    link = ScriptedLink(answers)
    link.round_trip = RoundTrip()
    MissionUploader(link, ITEMS[:2], as_int=True).run(lambda taken: None)
    assert link.round_trip.median_s == pytest.approx(0.1)


def test_an_upload_without_answers_backs_off() -> None:
    """12 s without an answer take 17 repetitions instead of 40: the wait doubles after each four losses."""
    link = ScriptedLink(lambda link, message: [])
    with pytest.raises(VehicleError, match="upload stopped at mission item 0: no answer"):
        MissionUploader(link, ITEMS, as_int=True).run(lambda taken: None)
    times_s = [time_s for time_s, message in link.sent if message.get_type() == "MISSION_COUNT"]
    waits_s = [later - earlier for earlier, later in pairwise(times_s)]
    assert waits_s[:4] == pytest.approx([0.3] * 4)
    assert waits_s[4:8] == pytest.approx([0.6] * 4)
    assert waits_s[8:12] == pytest.approx([1.2] * 4)
    assert len(times_s) < 18


def test_an_answer_to_a_request_sent_twice_is_not_measured() -> None:
    """Karn's rule holds for the download too."""

    def answers(link: ScriptedLink, message: Any) -> list[tuple[float, Any]]:
        if message.get_type() == "MISSION_REQUEST_LIST":
            return [(0.2, dialect.MAVLink_mission_count_message(OUR_SYSTEM, OUR_COMPONENT, 2))]
        if (
            message.get_type() == "MISSION_REQUEST_INT"
            and link.count("MISSION_REQUEST_INT", message.seq) == 2
        ):
            return [(0.001, item_message(link, message.seq, ITEMS[message.seq], as_int=True))]
        return []

    link = ScriptedLink(answers)
    assert len(MissionDownloader(link, as_int=True).run()) == 2
    assert link.round_trip.median_s == 0.2


def test_a_request_answered_at_once_is_measured() -> None:
    """Each item that was requested once tells the round trip."""

    def answers(link: ScriptedLink, message: Any) -> list[tuple[float, Any]]:
        if message.get_type() == "MISSION_REQUEST_LIST":
            return [(0.2, dialect.MAVLink_mission_count_message(OUR_SYSTEM, OUR_COMPONENT, 4))]
        if message.get_type() == "MISSION_REQUEST_INT":
            return [(0.1, item_message(link, message.seq, ITEMS[message.seq], as_int=True))]
        return []

    link = ScriptedLink(answers)
    assert len(MissionDownloader(link, as_int=True).run()) == 4
    assert link.round_trip.median_s == pytest.approx(0.1, abs=0.01)


def download_cpu_s(count: int) -> float:
    """What it takes to read so many items from on board, without collections of what other tests left."""

    def answers(link: ScriptedLink, message: Any) -> list[tuple[float, Any]]:
        if message.get_type() == "MISSION_REQUEST_LIST":
            return [(0.2, dialect.MAVLink_mission_count_message(OUR_SYSTEM, OUR_COMPONENT, count))]
        if message.get_type() == "MISSION_REQUEST_INT":
            return [(0.1, item_message(link, message.seq, ITEMS[1], as_int=True))]
        return []

    downloader = MissionDownloader(ForgetfulLink(answers), as_int=True)
    gc.disable()
    try:
        began_s = process_time()
        assert len(downloader.run()) == count
        return process_time() - began_s
    finally:
        gc.enable()


def test_the_work_for_an_item_does_not_grow_with_the_mission() -> None:
    """16,000 items on board take some 8 times as long as 2,000, not 64 times."""
    few_s, many_s = (min(download_cpu_s(count) for _ in range(2)) for count in (2_000, 16_000))
    assert many_s < 24 * few_s


@pytest.mark.parametrize(
    ("conditions", "known_s", "messages"),
    [
        (LinkConditions(delay_s=0.5), 0.005, 2000),
        (LinkConditions(delay_s=0.05, jitter_s=0.3), 0.1, 1000),
    ],
    ids=["200 times slower", "varying"],
)
def test_a_slow_link_is_not_flooded(conditions: LinkConditions, known_s: float, messages: int) -> None:
    """Without TIMESYNC only back-off and Karn's rule find the round trip.

    Without either of the two, 100 items take some 3,000 to 12,000 messages instead of 1,600 and 800.
    """
    link = VirtualLink(conditions, faults=old_copter())
    for _ in range(20):
        link.round_trip.measured(known_s)
    MissionStorage(link, as_int=False).upload(MISSION, lambda taken: None)
    assert len(link.sent) < messages
    assert link.now_s() < 45
