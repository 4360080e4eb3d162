"""A serial cable that is pulled in flight: the supervision goes on, and RTL is commanded when it is back."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from flight_replay import supervisor, vehicle
from flight_replay.events import DistanceToWaypoint, Event, LinkLost, LinkRestored, ReturnCommanded
from flight_replay.simulator.server import launch
from flight_replay.supervisor import Deadlines, FlightRecord, Plan, WallClock
from tests.helpers.fault_runs import DEADLINES, ROUTE, START, TAKEOFF_M
from tests.helpers.serial_cable import SerialCable, serial_cable

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
SPEEDUP = 10.0


def flown(
    folder: Path, in_auto: Callable[[SerialCable], None], lost: Callable[[SerialCable], None], **plan: Any
) -> tuple[FlightRecord, list[Event]]:
    """A flight over a serial cable, with what is done to it once AUTO flies and once the link is lost."""
    events: list[Event] = []
    pending = {DistanceToWaypoint: in_auto, LinkLost: lost}
    with (
        launch.run(START, speedup=SPEEDUP) as running,
        serial_cable(folder / "ttyUSB0", running.connection) as cable,
        vehicle.connect(str(cable.path), speedup=SPEEDUP) as connected,
    ):

        def listener(event: Event) -> None:
            events.append(event)
            action = pending.pop(type(event), None)
            if action is not None:
                action(cable)

        connected.upload(ROUTE)
        record = supervisor.fly(
            connected, WallClock(), Plan(mission=ROUTE, takeoff_altitude_m=TAKEOFF_M, **plan), listener
        )
    return record, events


def test_a_cable_that_is_plugged_in_again_is_used_again(tmp_path: Path) -> None:
    """The loss is reported, and so is the link's return; the flight ends as planned, in RTL."""
    record, events = flown(tmp_path, SerialCable.unplug, SerialCable.plug_in, duration_s=100.0)
    assert [type(event) for event in events if isinstance(event, LinkLost | LinkRestored)] == [
        LinkLost,
        LinkRestored,
    ]
    assert record.problem is None
    assert events[-1] == ReturnCommanded(True)


def test_a_cable_that_stays_unplugged_ends_with_a_reason(tmp_path: Path) -> None:
    """RTL is tried until the deadline, and the record says that the link is lost."""
    deadlines = Deadlines(give_up_wall_s=6.0, rtl_wall_s=DEADLINES.rtl_wall_s)
    record, events = flown(tmp_path, SerialCable.unplug, lambda _: None, duration_s=60.0, deadlines=deadlines)
    assert (record.ended, record.rtl_confirmed) == ("link lost", False)
    assert "link to the vehicle lost" in str(record.problem)
    assert events[-1] == ReturnCommanded(False)
