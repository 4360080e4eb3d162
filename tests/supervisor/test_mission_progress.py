"""Which items count as reached, and which were left out as another ground station sent the vehicle on."""

from __future__ import annotations

import pytest

from flight_replay.events import Notice, VehicleState, WaypointReached
from flight_replay.mission.items import Mission, change_speed, waypoint
from flight_replay.supervisor.mission_progress import MissionProgress
from flight_replay.supervisor.vehicle_interface import MissionCurrent
from tests.helpers.fake_vehicle import FakeClock, FakeVehicle, route
from tests.helpers.supervised import fake_flight


def at(time_s: float, north_m: float) -> VehicleState:
    return VehicleState(time_s, 47.0 + 9e-6 * north_m, 8.0, 30.0, (5.0, 0, 0), None, "AUTO", True)


def progress_at(seq: int, mission: Mission | None = None) -> MissionProgress:
    """That of a vehicle which at 100 s is in the middle of the leg to an item, 10 m long."""
    progress = MissionProgress(mission or route(40))
    progress.flies_to(seq, at(100.0, 10.0 * seq - 5.0))
    return progress


def told(progress: MissionProgress) -> list[str]:
    """What is told, without the next step."""
    return [jump.partition(";")[0] for jump in progress.jumps]


def test_items_whose_reports_are_lost_are_reached() -> None:
    """After 6 s without a word: it may have flown 230 m."""
    progress = progress_at(3)
    assert progress.flies_to(12, at(106.0, 110.0)) == list(range(3, 12))
    assert (progress.jumps, progress.reached[2], progress.reached[11]) == ([], 100.0, 106.0)


def test_items_that_cannot_have_been_flown_are_left_out() -> None:
    """150 m in 0.5 s; the item that it was sent on to counts when it is reached."""
    progress = progress_at(3)
    assert progress.flies_to(18, at(100.5, 28.0)) == []
    assert told(progress) == [
        "waypoints 3 to 17 were not flown: another ground station sent the vehicle on to item 18"
    ]
    assert progress.reached_item(18, at(130.0, 180.0)) == [18]
    assert progress.flies_to(19, at(130.5, 180.0)) == []
    assert sorted(progress.reached) == [1, 2, 18]
    assert len(progress.jumps) == 1


def test_a_command_that_it_was_sent_on_to_is_reported_at_once() -> None:
    """ArduCopter tells that a speed change is done before it tells that it flies to what follows."""
    progress = progress_at(3)
    assert progress.reached_item(17, at(100.2, 26.0)) == [17]
    assert progress.flies_to(18, at(100.5, 28.0)) == []
    assert told(progress) == [
        "waypoints 3 to 16 were not flown: another ground station sent the vehicle on to item 17"
    ]


def test_items_that_were_reported_as_reached_are_not_left_out() -> None:
    """The last of them just before the vehicle was sent on."""
    progress = progress_at(3)
    progress.reached_item(3, at(100.2, 30.0))
    progress.flies_to(18, at(100.5, 31.0))
    assert progress.jumps[0].startswith("waypoints 4 to 17 were not flown")
    assert sorted(progress.reached) == [1, 2, 3]


def test_what_is_flown_after_all_is_reached() -> None:
    """It was sent on, and then back."""
    progress = progress_at(3)
    progress.flies_to(18, at(100.5, 28.0))
    progress.flies_to(4, at(110.0, 60.0))
    assert progress.reached_item(4, at(115.0, 40.0)) == [4]
    assert sorted(progress.reached) == [1, 2, 4]


def test_waypoints_are_told_by_their_numbers() -> None:
    """Not by those of items, of which speed changes are some; one alone is told as one."""
    items = [
        change_speed(3.0),
        *route(4).items,
        change_speed(2.0),
        waypoint(47.01, 8.0, 30.0),
        waypoint(47.02, 8.0, 30.0),
    ]
    progress = progress_at(5, Mission(tuple(items)))
    progress.reached_item(5, at(100.1, 50.0))
    progress.flies_to(8, at(100.5, 50.0))
    assert told(progress) == [
        "waypoint 5 was not flown: another ground station sent the vehicle on to item 8"
    ]


@pytest.mark.parametrize("seq", [0, 30])
def test_where_the_mission_begins_is_not_a_jump(seq: int) -> None:
    """Whatever the vehicle was at before."""
    progress = MissionProgress(route(40))
    progress.flies_to(seq, at(100.0, 0.0))
    progress.flies_to(1, at(100.2, 0.0))
    assert progress.jumps == []


def test_a_flight_that_is_sent_on_goes_on() -> None:
    """It is told at once, and in the end; what was left out does not count as reached."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def send_on() -> None:
        vehicle.auto_s += 80.0  # Twenty items.
        vehicle.place_m = vehicle.place_m - [200.0, 0.0]

    vehicle.schedule.append((30.0, send_on))
    flight = fake_flight(vehicle, duration_s=None)
    record = flight.fly()
    assert record.ended == "mission complete"
    assert record.problem is not None
    assert " were not flown: another ground station sent the vehicle on to item 24; " in record.problem
    assert record.waypoints_reached == 20
    assert Notice(record.problem, warning=True) in flight.events
    assert len(flight.of(WaypointReached)) == 20


def test_a_mission_that_was_left_out_to_its_end_is_told() -> None:
    """Sent on to the last item, which ends a flight that does not wait for it."""
    progress = progress_at(3)
    progress.flies_to(40, at(100.5, 28.0))
    assert progress.jumps[0].startswith("waypoints 3 to 39 were not flown")


def begun() -> MissionProgress:
    """That of a vehicle which enters AUTO at 100 s, 10 m before the first of 40 waypoints."""
    progress = MissionProgress(route(40))
    progress.begin(at(100.0, 0.0))
    return progress


def test_a_mission_that_begins_in_its_middle_is_told() -> None:
    """Another station set the current item before AUTO: by the same rule as in flight."""
    progress = begun()
    assert progress.flies_to(0, at(100.1, 0.0)) == []
    assert progress.flies_to(20, at(101.0, 0.0)) == []
    assert told(progress) == [
        "waypoints 1 to 19 were not flown: another ground station sent the vehicle on to item 20"
    ]
    assert not begun().flies_to(1, at(101.0, 1.0))


def test_the_first_number_in_auto_may_be_from_before() -> None:
    """A vehicle that was at another item, and restarts its mission in AUTO; the second number counts."""
    progress = begun()
    assert progress.is_outdated(20, at(100.1, 0.0))
    assert not progress.is_outdated(20, at(100.3, 0.0))
    assert not begun().is_outdated(1, at(100.1, 0.0))


@pytest.mark.parametrize(("points", "seq", "flown"), [(40, 21, 20), (40, 40, 1)])
def test_auto_that_begins_in_the_middle_is_a_problem(points: int, seq: int, flown: int) -> None:
    """At the last item, too, where the flight ends at once."""
    vehicle = FakeVehicle(FakeClock(), points=points)
    request_takeoff = vehicle.request_takeoff

    def take_off(altitude_m: float) -> None:
        request_takeoff(altitude_m)
        vehicle.auto_s = (seq - 1) * vehicle.item_s
        vehicle.place_m = vehicle.place_m * 0.0 - [10.0 * (seq - 1), 0.0]

    vehicle.request_takeoff = take_off  # type: ignore[method-assign]
    record = fake_flight(vehicle, duration_s=60.0).fly()
    assert record.problem is not None
    assert f"waypoints 1 to {seq - 1} were not flown" in record.problem
    assert record.waypoints_reached < flown


def test_the_number_from_just_before_auto_ends_nothing() -> None:
    """That of the last item, told after AUTO was requested and before it is entered."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    request_mode = vehicle.request_mode

    def request(mode: str) -> None:
        if mode == "AUTO":
            vehicle.queue.append(MissionCurrent(40, 40))
        request_mode(mode)

    vehicle.request_mode = request  # type: ignore[method-assign]
    record = fake_flight(vehicle).fly()
    assert (record.ended, record.problem) == ("duration", None)


def test_a_few_near_items_that_cannot_have_been_flown_are_left_out() -> None:
    """Six of 3 m in 0.3 s at 1.2 m/s; as many as its speed allows may have been, as positions are late."""
    items = tuple(waypoint(47.0 + 2.7e-5 * i, 8.0, 30.0) for i in range(1, 41))

    def slow(time_s: float, north_m: float) -> VehicleState:
        return VehicleState(time_s, 47.0 + 9e-6 * north_m, 8.0, 30.0, (1.2, 0, 0), None, "AUTO", True)

    for seq, reached in ((11, []), (7, [5, 6])):
        progress = MissionProgress(Mission(items))
        progress.flies_to(5, slow(100.0, 13.5))
        assert progress.flies_to(seq, slow(100.3, 13.9)) == reached
    assert progress.jumps == []


def test_one_item_whose_corner_is_cut_is_reached() -> None:
    """However far from it the vehicle turns, within reason."""
    progress = progress_at(3)
    assert progress.flies_to(4, at(100.1, -15.0)) == [3]
    assert progress.jumps == []
