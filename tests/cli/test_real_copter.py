"""Replays on a real ArduCopter in ArduPilot SITL.

``SITL_BINARY`` names the binary (3.3 to 4.7); without it these tests are skipped.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from flight_replay import supervisor
from flight_replay.cli.main import main
from flight_replay.events import Event, LinkLost, LinkRestored, ReturnCommanded
from flight_replay.exceptions import VehicleError
from flight_replay.mavlink import dialect
from flight_replay.mission.items import Mission, waypoint
from flight_replay.supervisor import FlightRecord, Plan
from flight_replay.vehicle import ConnectedVehicle, connect
from flight_replay.vehicle.sitl import simulator
from tests.helpers.fault_link import FaultLink, Trigger, fault_link
from tests.helpers.fault_runs import ROUTE, START
from tests.helpers.link_conditions import LinkConditions
from tests.helpers.paths import SAMPLE

pytestmark = [
    pytest.mark.sitl,
    pytest.mark.skipif("SITL_BINARY" not in os.environ, reason="SITL_BINARY names no ArduCopter"),
]

SPEEDUP = 10.0


class Clock:
    def monotonic_s(self) -> float:
        return time.monotonic()


@contextmanager
def copter(
    conditions: LinkConditions | None = None, *triggers: Trigger
) -> Iterator[tuple[ConnectedVehicle, FaultLink, list[Event]]]:
    """A real copter behind a link."""
    events: list[Event] = []
    with (
        simulator("sitl", None, START, speedup=SPEEDUP) as connection,
        fault_link(connection, conditions, triggers) as link,
        connect(link.connection, speedup=SPEEDUP, listener=events.append) as vehicle,
    ):
        yield vehicle, link, events


def fly(vehicle: ConnectedVehicle, events: list[Event], duration_s: float = 20.0) -> FlightRecord:
    vehicle.upload(ROUTE)
    plan = Plan(mission=ROUTE, duration_s=duration_s, takeoff_altitude_m=8.0)
    return supervisor.fly(vehicle, Clock(), plan, events.append)


@pytest.mark.parametrize("speedup", ["1", "10"])
def test_the_sample_is_replayed(speedup: str, capsys: pytest.CaptureFixture[str]) -> None:
    """From log to confirmed RTL, 60 s of AUTO by the vehicle's clock."""
    assert main(["--tlog", str(SAMPLE), "--sim", "sitl", "--speedup", speedup, "--json"]) == 0
    flight = json.loads(capsys.readouterr().out)["flight"]
    assert flight["ended"] == "duration"
    assert flight["auto_s"] == pytest.approx(60, abs=1)
    assert flight["rtl_confirmed"]
    assert flight["waypoints_reached"] >= 20


@pytest.mark.parametrize("speedup", ["1", "10"])
def test_the_sample_is_followed(speedup: str, capsys: pytest.CaptureFixture[str]) -> None:
    """In step, as near as the flight model predicts for this firmware from 4.1 on; GUID_TIMEOUT restored."""
    options = ["--tlog", str(SAMPLE), "--from", "85", "--to", "125", "--duration", "all"]
    assert main([*options, "--mode", "guided", "--sim", "sitl", "--speedup", speedup, "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    flight, predicted = summary["flight"], summary["route"]["predicted"]
    assert flight["ended"] == "recording complete"
    assert flight["rtl_confirmed"]
    assert flight["height_error_m"]["max"] < 0.5
    assert flight["alignment"]["waited_s"] < 1.0
    old = "3." in flight["vehicle"]
    largest_m = 4.0 if old else predicted["position_error_m"]["mean"] + 0.15
    assert flight["position_error_m"]["mean"] < largest_m


@pytest.mark.parametrize(
    "conditions",
    [LinkConditions(loss=0.2), LinkConditions(delay_s=0.2), LinkConditions(duplicated=0.2, corrupt=0.05)],
    ids=["20 % lost", "late", "duplicated and corrupt"],
)  # fmt: skip
def test_a_bad_link_does_not_change_the_flight(conditions: LinkConditions) -> None:
    """The mission is verified on board and flown, and RTL is confirmed."""
    with copter(conditions) as (vehicle, _, events):
        record = fly(vehicle, events)
    assert (record.ended, record.problem, record.rtl_confirmed) == ("duration", None, True)
    assert ReturnCommanded(True) in events


def test_a_restored_link_is_used_again() -> None:
    """A silence of five seconds in AUTO is reported, and the flight ends as asked."""

    def in_auto(message: object) -> bool:
        return getattr(message, "custom_mode", 0) == 3 and message.get_type() == "HEARTBEAT"  # type: ignore[attr-defined]

    with copter(None, Trigger(in_auto, lambda link: link.cut(5.0))) as (vehicle, _, events):
        record = fly(vehicle, events, 90.0)
    assert record.problem is None
    assert [type(e) for e in events if isinstance(e, LinkLost | LinkRestored)] == [LinkLost, LinkRestored]


def test_positions_on_board_are_within_a_centimetre() -> None:
    """As far as the firmware's protocol carries them."""
    places = [(47.39774213, 8.54559487), (-47.39774213, -179.9999999), (89.1234567, 179.9999999)]
    mission = Mission(tuple(waypoint(lat, lon, 30.0) for lat, lon in places))
    with copter() as (vehicle, _, _events):
        vehicle.upload(mission)
        found = vehicle.mission_on_board()
        limit = 0.6e-7 if vehicle.identity.takes_item_int else 1e-5
    for item, (lat, lon) in zip(found.items, places, strict=True):
        assert abs(item.lat_deg - lat) < limit
        assert abs(item.lon_deg - lon) < limit


def test_limits_are_raised_and_restored() -> None:
    """By the firmware's own parameter names."""
    with copter() as (vehicle, _, _events):
        wanted = vehicle.limits_as_parameters({"wp_speed_m_s": 9.0, "wp_accel_m_s2": 2.2})
        assert len(wanted) == 2
        before = vehicle.parameters(wanted)
        with vehicle.parameters_set(wanted):
            assert vehicle.parameters(wanted) == pytest.approx(wanted)
        assert vehicle.parameters(wanted) == before


def test_a_reboot_before_arming_ends_the_flight() -> None:
    """Nothing is armed."""
    with copter() as (vehicle, _, events):
        if not vehicle.identity.takes_item_int:
            pytest.skip("the simulator of 3.3 does not reboot")
        vehicle.upload(ROUTE)
        vehicle.wait_position(60.0)
        reboot = dialect.MAVLink_command_long_message(1, 1, 246, 0, 1, 0, 0, 0, 0, 0, 0)
        vehicle.link.send(reboot)
        vehicle.link.send(reboot)
        with pytest.raises(VehicleError, match="rebooted"):
            supervisor.fly(vehicle, Clock(), Plan(mission=ROUTE, takeoff_altitude_m=8.0), events.append)


def test_a_fence_on_the_map_is_read() -> None:
    """Polygon and circle are read as areas once the fence is enabled."""
    corners = [(47.39, 8.53), (47.41, 8.53), (47.41, 8.56), (47.39, 8.56)]
    items = [(5001, 4.0, *corner) for corner in corners] + [(5004, 30.0, 47.4, 8.55)]
    with simulator("sitl", None, START, speedup=SPEEDUP) as connection:
        with connect(connection, speedup=SPEEDUP) as vehicle:
            if not vehicle.identity.takes_item_int:
                pytest.skip("3.3 keeps its fence in another way")
            vehicle.link.send(dialect.MAVLink_mission_count_message(1, 1, len(items), 1))
            for seq, (command, first, lat, lon) in enumerate(items):
                time.sleep(0.1)
                place = round(lat * 1e7), round(lon * 1e7), 0.0
                vehicle.link.send(
                    dialect.MAVLink_mission_item_int_message(
                        1, 1, seq, 0, command, 0, 1, first, 0, 0, 0, *place, 1
                    )
                )
            assert vehicle.fence_areas() == ()
            vehicle.set_known_parameters({"FENCE_ENABLE": 1.0, "FENCE_TYPE": 4.0})
        time.sleep(0.5)
        with connect(connection, speedup=SPEEDUP) as vehicle:
            polygon, circle = vehicle.fence_areas()
    assert [n for corner in polygon.corners for n in corner] == pytest.approx(
        [n for corner in corners for n in corner]
    )
    assert (circle.radius_m, circle.stay_inside) == (30.0, False)
