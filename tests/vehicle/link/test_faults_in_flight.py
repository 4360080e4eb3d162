"""Errors of the program on the link's thread in flight: it goes on, or the vehicle is sent home at once."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count

import pytest

from flight_replay import supervisor
from flight_replay.events import Event, LinkLost, Notice, ReturnCommanded, WaypointReached
from flight_replay.mavlink import Message
from flight_replay.simulator.server import launch
from flight_replay.supervisor import Deadlines, FlightRecord, Plan, WallClock
from flight_replay.supervisor.vehicle_interface import Heartbeat
from flight_replay.vehicle import connect
from flight_replay.vehicle.protocol.telemetry import Telemetry
from tests.helpers.fault_runs import ROUTE, START, TAKEOFF_M

SPEEDUP = 10.0
DEADLINES = Deadlines(give_up_wall_s=6.0)
FAULT = "internal error (ValueError: no); please report it with the output of -v"


def flown(
    monkeypatch: pytest.MonkeyPatch, fails: Callable[[list[Event]], bool]
) -> tuple[FlightRecord, list[Event], str]:
    """A flight in which messages of the vehicle cannot be processed while ``fails``; its mode afterwards."""
    events: list[Event] = []
    receive = Telemetry.receive

    def failing(self: Telemetry, message: Message) -> None:
        if any(isinstance(event, WaypointReached) for event in events) and fails(events):
            raise ValueError("no")
        receive(self, message)

    monkeypatch.setattr(Telemetry, "receive", failing)
    with launch.run(START, speedup=SPEEDUP) as running:
        with connect(running.connection, speedup=SPEEDUP, listener=events.append) as connected:
            connected.upload(ROUTE)
            plan = Plan(mission=ROUTE, takeoff_altitude_m=TAKEOFF_M, duration_s=60.0, deadlines=DEADLINES)
            record = supervisor.fly(connected, WallClock(), plan, events.append)
        monkeypatch.undo()
        with connect(running.connection, speedup=SPEEDUP) as connected:
            heartbeats: list[Heartbeat] = []
            while not heartbeats:
                heartbeats = [each for each in connected.reports(1.0) if isinstance(each, Heartbeat)]
    return record, events, heartbeats[-1].mode


def warnings(events: list[Event]) -> list[str]:
    return [event.text for event in events if isinstance(event, Notice) and event.warning]


def test_a_message_that_cannot_be_processed_is_told_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor can every tenth after it: the flight ends as planned."""
    number = count()
    record, events, _ = flown(monkeypatch, lambda _: next(number) % 10 == 0)
    assert (record.ended, record.problem, record.rtl_confirmed) == ("duration", None, True)
    (told,) = warnings(events)
    assert told.startswith("cannot process ")
    assert told.endswith(FAULT)


@pytest.mark.parametrize("recovers", [False, True])
def test_where_nothing_can_be_processed_rtl_is_commanded(
    monkeypatch: pytest.MonkeyPatch, recovers: bool
) -> None:
    """At once, not when the link counts as lost; whether it is confirmed can be known if that ends."""

    def fails(events: list[Event]) -> bool:
        return not recovers or not any(FAULT in text for text in warnings(events)[1:])

    record, events, mode = flown(monkeypatch, fails)
    assert mode in {"RTL", "LAND"}
    assert record.ended == "internal error"
    assert record.rtl_confirmed is recovers
    assert ReturnCommanded(recovers) in events
    ended = next(event for event in events if isinstance(event, Notice) and "nothing is heard" in event.text)
    assert not any(isinstance(event, LinkLost) for event in events[: events.index(ended)])
    assert str(record.problem).endswith(FAULT)
    assert ("take control with the transmitter" in str(record.problem)) is not recovers
    assert len(record.flown)


def test_a_listener_that_fails_is_no_reason_to_hear_nothing() -> None:
    """It is told of faults where the reports of the vehicle are taken."""
    told: list[Event] = []

    def listener(event: Event) -> None:
        told.append(event)
        if isinstance(event, Notice):
            raise RuntimeError("no")

    with (
        launch.run(START, speedup=SPEEDUP) as running,
        connect(running.connection, speedup=SPEEDUP, listener=listener) as connected,
    ):
        connected.link.faults.note("process PING", ValueError("no"))
        for _ in range(3):
            assert connected.reports(60.0)
    assert warnings(told) == [f"cannot process PING: {FAULT}"]
