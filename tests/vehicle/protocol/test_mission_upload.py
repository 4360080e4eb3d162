"""A mission is on board completely or not at all, whatever the link loses, delays, duplicates or reorders."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flight_replay.exceptions import FlightReplayError, MissionError, VehicleError
from flight_replay.geometry.geodesy import distance_m
from flight_replay.mavlink import MISSION_RESULTS, dialect
from flight_replay.mission.items import Command, Frame, Mission, MissionItem, change_speed, waypoint
from flight_replay.simulator.autopilot.faults import Faults, MissionFaults
from flight_replay.simulator.autopilot.location import Start
from flight_replay.vehicle.link.own_ids import OUR_COMPONENT, OUR_SYSTEM
from flight_replay.vehicle.link.vehicle_link import is_for_us
from flight_replay.vehicle.protocol.mission_download import FENCE, MISSION, MissionDownloader
from flight_replay.vehicle.protocol.mission_items import difference, item_message
from flight_replay.vehicle.protocol.mission_storage import MissionStorage
from tests.helpers.link_conditions import LinkConditions
from tests.helpers.virtual_link import VirtualLink


def route(count: int) -> Mission:
    """Waypoints, every tenth a spline with a hold, every seventh followed by a change of speed."""
    items: list[MissionItem] = []
    for i in range(1, count + 1):
        items.append(waypoint(47.397742 + 1e-4 * i, 8.545594, 30.0, hold_s=i % 3, spline=i % 10 == 0))
        if i % 7 == 0:
            items.append(change_speed(1.5 + i / 10))
    return Mission(tuple(items))


def upload(link: VirtualLink, mission: Mission, *, as_int: bool = True) -> MissionStorage:
    """Upload a mission over a link whose round trip is known."""
    storage = MissionStorage(link, as_int=as_int)
    storage.upload(mission, lambda done: None)
    return storage


CONDITIONS = {
    "clear": LinkConditions(),
    "5 % lost": LinkConditions(loss=0.05),
    "20 % lost": LinkConditions(loss=0.2),
    "40 % lost": LinkConditions(loss=0.4),
    "0.5 s late": LinkConditions(delay_s=0.5),
    "all at once": LinkConditions(loss=0.1, delay_s=0.05, jitter_s=0.15, duplicated=0.2),
}


@pytest.mark.parametrize("conditions", CONDITIONS.values(), ids=CONDITIONS.keys())
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_mission_on_board_is_the_one_sent(conditions: LinkConditions, seed: int) -> None:
    """Whatever the link does, a verified mission is on board item for item."""
    link = VirtualLink(conditions, seed=seed)
    storage = upload(link, route(100))
    stored = [item.command for item in link.autopilot.store.items[1:]]
    assert stored == [item.command for item in route(100).items]
    assert storage.verified()


@pytest.mark.parametrize(
    ("conditions", "limit_s"),
    [("clear", 0.7), ("20 % lost", 5.0), ("40 % lost", 25.0), ("0.5 s late", 20.0)],
)
def test_a_bad_link_costs_seconds_not_minutes(conditions: str, limit_s: float) -> None:
    """No loss waits for ArduPilot's own second, and no delay is paid for each item."""
    link = VirtualLink(CONDITIONS[conditions], seed=5)
    began_s = link.now_s()
    upload(link, route(100))
    assert link.now_s() - began_s < limit_s


@given(
    st.floats(0, 0.3),
    st.floats(0.001, 0.3),
    st.floats(0, 0.3),
    st.floats(0, 0.3),
    st.integers(0, 10**6),
)
@settings(max_examples=12)
def test_no_link_makes_a_wrong_mission_verified(
    loss: float, delay_s: float, jitter_s: float, duplicated: float, seed: int
) -> None:
    """An upload ends with the mission on board or with an error, never with another mission."""
    link = VirtualLink(
        LinkConditions(loss=loss, delay_s=delay_s, jitter_s=jitter_s, duplicated=duplicated), seed=seed
    )
    sent = route(12)
    try:
        upload(link, sent)
    except FlightReplayError:
        return
    stored = link.autopilot.store.items[1:]
    places = [(item.lat_e7, item.lon_e7) for item in stored if item.command != Command.CHANGE_SPEED]
    assert places == [(round(i.lat_deg * 1e7), round(i.lon_deg * 1e7)) for _, i in sent.waypoints]


REFUSALS = sorted(set(MISSION_RESULTS) - {0, 13, 14, 15, 1, 16})


@pytest.mark.parametrize("result", REFUSALS, ids=lambda r: MISSION_RESULTS[r].replace(" ", "-"))
def test_a_refused_item_is_named_with_the_vehicles_reason(result: int) -> None:
    """Each MISSION_ACK code ends the upload at once, in one sentence."""
    link = VirtualLink(faults=Faults(mission=MissionFaults(result_of_item={5: result})))
    with pytest.raises(MissionError) as caught:
        upload(link, route(10))
    if result == dialect.MAV_MISSION_NO_SPACE:
        assert "no space for 11 mission items" in str(caught.value)
    else:
        assert f"mission item 5: {MISSION_RESULTS[result]}" in str(caught.value)
    assert link.now_s() < 3


@pytest.mark.parametrize("result", [1, 13, 14, 15], ids=["error", "sequence", "denied", "cancelled"])
def test_a_temporary_result_is_retried_until_a_deadline(result: int) -> None:
    """A busy vehicle is tried again until the deadline."""
    link = VirtualLink(faults=Faults(mission=MissionFaults(result_of_item={5: result})))
    with pytest.raises(FlightReplayError):
        upload(link, route(10))
    assert link.now_s() < 60


def test_a_refused_upload_is_an_error() -> None:
    """A MISSION_ACK against the whole mission, after the last item, is not a success."""
    link = VirtualLink(faults=Faults(mission=MissionFaults(result_of_upload=2)))
    with pytest.raises(MissionError, match="refused mission item 10: unsupported frame"):
        upload(link, route(9))


def test_a_mission_too_long_leaves_the_old_one_on_board() -> None:
    """The vehicle reports that it has no space before anything is overwritten."""
    link = VirtualLink(faults=Faults(mission=MissionFaults(capacity=20)))
    upload(link, route(10))
    with pytest.raises(MissionError, match="no space for 34 mission items; choose fewer with --max-points"):
        upload(link, route(30))
    assert len(link.autopilot.store.items) == 12


def test_a_dead_link_ends_the_upload() -> None:
    """Without an answer the upload stops at its deadline."""
    link = VirtualLink(LinkConditions(loss=1.0))
    with pytest.raises(VehicleError, match="upload stopped at mission item 0"):
        upload(link, route(3))
    assert link.now_s() < 15


def test_another_stations_upload_is_waited_for() -> None:
    """While another ground station uploads, ours is denied; it succeeds once the other has timed out."""
    link = VirtualLink()
    other = dialect.MAVLink(None, 255, 190)
    frame = dialect.MAVLink_mission_count_message(1, 1, 5).pack(other)
    for message, sender in link.channel.receive(frame):
        link.ground_link.handle(message, sender)
    assert upload(link, route(3)).verified()
    assert link.now_s() > 5


def test_requests_to_another_station_are_not_answered() -> None:
    """An item is sent only for a request that is addressed to us."""
    link = VirtualLink()
    heard = dialect.MAVLink_mission_request_message(255, 190, 2)
    storage = upload(link, route(4))
    sent = len(link.sent)
    link._deliver(False, heard.pack(dialect.MAVLink(None, 1, 1)))
    link.pass_time(1.0)
    assert len(link.sent) == sent
    assert storage.verified()


def test_a_change_by_another_station_is_noticed() -> None:
    """After another ground station changes the mission, it is no longer verified."""
    link = VirtualLink()
    storage = upload(link, route(4))
    other = dialect.MAVLink(None, 255, 190)
    frame = dialect.MAVLink_mission_clear_all_message(1, 1).pack(other)
    for message, sender in link.channel.receive(frame):
        link.ground_link.handle(message, sender)
    assert not storage.verified()


def test_nothing_is_verified_before_an_upload() -> None:
    """A mission that was not uploaded is never verified."""
    assert not MissionStorage(VirtualLink(), as_int=True).verified()


def test_the_mission_on_board_is_downloaded_with_home() -> None:
    """Home is not among the items; nothing on board is an empty mission."""
    link = VirtualLink()
    link.pass_time(20)
    assert MissionStorage(link, as_int=True).download().items == ()
    upload(link, route(3))
    found = MissionStorage(link, as_int=True).download()
    assert len(found.items) == 3
    assert found.home is not None
    assert found.home.alt_amsl_m == pytest.approx(488, abs=0.1)


PLACES = [
    (47.3977, 8.5456), (-35.3632621, 149.1652374), (0.0000001, -0.0000001), (89.9, 12.0),
    (-89.5, -179.9999999), (12.3456789, 179.9999999), (64.1234567, -180.0),
]  # fmt: skip


@pytest.mark.parametrize(("lat_deg", "lon_deg"), PLACES)
def test_positions_on_board_are_within_a_centimetre_anywhere(lat_deg: float, lon_deg: float) -> None:
    """MISSION_ITEM_INT holds them at any latitude and across the antimeridian."""
    link = VirtualLink(start=Start(lat_deg, lon_deg, 10.0))
    places = [(lat_deg + 1.23456e-5 * i, lon_deg) for i in range(1, 4)]
    upload(link, Mission(tuple(waypoint(lat, lon, 30.0) for lat, lon in places)))
    for stored, (lat, lon) in zip(link.autopilot.store.items[1:], places, strict=True):
        assert float(distance_m(stored.lat_e7 / 1e7, stored.lon_e7 / 1e7, lat, lon)) < 0.012


def test_old_firmware_gets_float_items() -> None:
    """ArduCopter 3.3 does not know MISSION_ITEM_INT: MISSION_ITEM is sent, requested and compared."""
    link = VirtualLink(faults=Faults(mission=MissionFaults(supports_item_int=False)))
    assert upload(link, route(5), as_int=False).verified()
    kinds = {message.get_type() for message in link.sent}
    assert "MISSION_ITEM" in kinds
    assert not kinds & {"MISSION_ITEM_INT", "MISSION_REQUEST_INT"}


BASE = waypoint(47.0, 8.0, 30.0, hold_s=2)
UNLIKE = {
    "command": (MissionItem(21, 3, (2, 0, 0, 0), 47.0, 8.0, 30.0), "command 21 instead of 16"),
    "hold": (waypoint(47.0, 8.0, 30.0, hold_s=4), "param1 4 instead of 2"),
    "frame": (MissionItem(16, Frame.ABSOLUTE, (2, 0, 0, 0), 47.0, 8.0, 30.0), "frame 0 instead of 3"),
    "place": (waypoint(47.0000003, 8.0, 30.0, hold_s=2), "position 47.0000003"),
    "no height": (waypoint(47.0, 8.0, math.nan, hold_s=2), "altitude nan m instead of 30 m"),
    "no hold": (MissionItem(16, 3, (math.nan, 0, 0, 0), 47.0, 8.0, 30.0), "param1 nan instead of 2"),
    "height": (waypoint(47.0, 8.0, 30.2, hold_s=2), "altitude 30.2 m instead of 30 m"),
}


class IntegersOnly(VirtualLink):
    """A vehicle that knows only MISSION_ITEM_INT, and requests it."""

    def send(self, message: Any) -> None:
        if message.get_type() not in ("MISSION_ITEM", "MISSION_REQUEST"):
            super().send(message)

    def _deliver(self, outward: bool, frame: bytes) -> None:
        message = dialect.MAVLink(None).parse_buffer(frame)[0]
        if not outward and message.get_type() == "MISSION_REQUEST":
            asks = dialect.MAVLink_mission_request_int_message(OUR_SYSTEM, OUR_COMPONENT, message.seq)
            frame = asks.pack(dialect.MAVLink(None, self.system, self.component))
        super()._deliver(outward, frame)


def test_a_vehicle_that_requests_integers_gets_them() -> None:
    """Its requests show that it knows MISSION_ITEM_INT, even if its capabilities were not received."""
    link = IntegersOnly()
    storage = upload(link, route(12), as_int=False)
    assert storage.verified()
    assert [item.command for item in link.autopilot.store.items[1:]] == [i.command for i in route(12).items]


@pytest.mark.parametrize(("found", "words"), UNLIKE.values(), ids=UNLIKE.keys())
def test_each_difference_is_named(found: MissionItem, words: str) -> None:
    """A difference that would change the flight is described."""
    assert (difference(BASE, found, as_int=True) or "").startswith(words)


def test_what_ardupilot_rounds_is_not_a_difference() -> None:
    """Whole seconds of hold, centimetres of altitude, and the unused position of a command."""
    assert (
        difference(waypoint(47, 8, 30.006, hold_s=2.9), waypoint(47, 8, 30.0, hold_s=2), as_int=True) is None
    )
    speed = MissionItem(Command.CHANGE_SPEED, 0, (1.0, 4.001, -1.0, 0.0), 47.0, 8.0, 12.0)
    assert difference(change_speed(4.0), speed, as_int=True) is None
    assert difference(change_speed(4.0), change_speed(5.0), as_int=True) == "param2 5 instead of 4"


def test_longitudes_beyond_180_degrees_are_wrapped() -> None:
    """A route across the antimeridian fits the 32 bits of the field."""
    link = VirtualLink()
    message = item_message(link, 1, waypoint(10.0, 220.0, 30.0), as_int=True)
    assert message.y == round(-140 * 1e7)
    found = waypoint(10.0, -140.0, 30.0)
    assert difference(waypoint(10.0, 220.0, 30.0), found, as_int=True) is None
    assert math.isclose(message.x, 10 * 1e7)


def test_our_component_id_is_not_that_of_a_common_ground_station() -> None:
    """Several ground stations share a link."""
    assert (OUR_SYSTEM, OUR_COMPONENT) not in {(255, 0), (255, 190), (255, 230)}


@pytest.mark.parametrize(
    ("system", "component", "ours"),
    [
        (OUR_SYSTEM, OUR_COMPONENT, True),
        (OUR_SYSTEM, 0, True),
        (0, 0, True),
        (255, 190, False),
        (1, 0, False),
    ],
)
def test_what_is_for_us(system: int, component: int, ours: bool) -> None:
    """Messages to us, to all of our system or to everybody; not those to other stations."""
    assert is_for_us(dialect.MAVLink_mission_ack_message(system, component, 0)) is ours


@pytest.mark.parametrize("as_int", [True, False], ids=["4.6", "3.3"])
def test_a_link_that_became_slow_is_measured_again(as_int: bool) -> None:
    """A round trip 200 times longer than before costs seconds, not a minute of repetitions."""
    link = VirtualLink(LinkConditions(delay_s=0.5))
    for _ in range(20):
        link.round_trip.measured(0.005)
    upload(link, route(100), as_int=as_int)
    assert link.now_s() < 25
    assert len(link.sent) < 700


@pytest.mark.parametrize(("kind", "name"), [(MISSION, "mission"), (FENCE, "fence")])
def test_a_download_that_fails_says_of_what(kind: int, name: str) -> None:
    """A fence is no mission."""
    link = VirtualLink(LinkConditions(loss=1.0))
    with pytest.raises(VehicleError, match=f"cannot download the {name} in 12 s: no answer; check the link"):
        MissionDownloader(link, as_int=True, mission_type=kind).run()


class Armed:
    """Refuses a vehicle that is armed by what was done to its mission."""

    def __init__(self, *, armed: bool = True) -> None:
        self.armed = armed

    def refuse(self, consequence: str) -> None:
        if self.armed:
            raise VehicleError(consequence)


def kinds_sent(link: VirtualLink) -> set[str]:
    """The types of the messages sent."""
    return {message.get_type() for message in link.sent}


def test_the_mission_of_an_armed_vehicle_is_not_replaced() -> None:
    """It may be flying it: nothing is sent."""
    link = VirtualLink()
    storage = MissionStorage(link, as_int=True, refuse_armed=Armed().refuse)
    with pytest.raises(VehicleError, match="its mission is not replaced"):
        storage.upload(route(3), lambda done: None)
    assert not link.sent


def test_a_vehicle_that_is_armed_during_the_upload_is_not_sent_off() -> None:
    """Its mission is completed, since it cannot have the old one back, but its place in it is not changed."""
    link, pilot = VirtualLink(), Armed(armed=False)

    def arm(done: int) -> None:
        pilot.armed = True

    storage = MissionStorage(link, as_int=True, refuse_armed=pilot.refuse)
    with pytest.raises(
        VehicleError, match="its mission was replaced meanwhile, but not set to its beginning"
    ):
        storage.upload(route(3), arm)
    assert len(link.autopilot.store.items) == 4
    assert "MISSION_SET_CURRENT" not in kinds_sent(link)


def test_a_count_is_not_repeated_once_the_vehicle_is_armed() -> None:
    """The first one may have arrived; another would drop the mission that it flies."""
    link, pilot = VirtualLink(LinkConditions(loss=1.0)), Armed(armed=False)

    def refuse(consequence: str) -> None:
        pilot.refuse(consequence)
        pilot.armed = True

    storage = MissionStorage(link, as_int=True, refuse_armed=refuse)
    with pytest.raises(VehicleError, match="its mission may be incomplete"):
        storage.upload(route(3), lambda done: None)
    assert [m.get_type() for m in link.sent if m.get_type() != "TIMESYNC"] == ["MISSION_COUNT"]


def test_a_mission_that_mavlink_cannot_count_is_refused() -> None:
    """MISSION_COUNT has 16 bits."""
    link = VirtualLink()
    mission = Mission((waypoint(47.0, 8.0, 30.0),) * 65535)
    with pytest.raises(MissionError, match="65535 items, too many for MAVLink"):
        upload(link, mission)
    assert not link.sent
