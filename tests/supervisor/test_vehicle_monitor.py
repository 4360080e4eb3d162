"""What the supervisor knows of a vehicle follows from its reports, in their order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest

from flight_replay.events import Event, LinkLost, Severity, StatusText, VehicleState, WaypointReached
from flight_replay.mission.items import Command, Frame, Mission, MissionItem
from flight_replay.supervisor import Deadlines
from flight_replay.supervisor.flight_ended import FlightEnded
from flight_replay.supervisor.vehicle_interface import (
    Heartbeat,
    MissionCurrent,
    MissionItemReached,
    PrearmStatus,
    Rebooted,
    Report,
    Request,
    RequestAck,
    RequestLost,
)
from flight_replay.supervisor.vehicle_monitor import VehicleMonitor
from tests.helpers.fake_vehicle import FakeClock, FakeVehicle, route


class Scripted:
    """A monitor of a vehicle that reports what a test gives it."""

    def __init__(self) -> None:
        self.clock = FakeClock(100.0)
        self.events: list[Event] = []
        self.timeouts_s: list[float] = []
        self._reports: list[Report] = []
        vehicle = FakeVehicle(self.clock)
        vehicle.reports = self._take  # type: ignore[method-assign]
        self.monitor = VehicleMonitor(vehicle, self.clock, self.events.append, Deadlines())

    def _take(self, timeout_s: float) -> Sequence[Report]:
        self.timeouts_s.append(timeout_s)
        reports, self._reports = self._reports, []
        return reports

    def arrive(self, *reports: Report) -> None:
        """Reports that the next step fetches."""
        self._reports += reports

    def process(self, *reports: Report) -> VehicleMonitor:
        """The monitor after these reports."""
        self.arrive(*reports)
        self.monitor.catch_up()
        return self.monitor


def state(time_s: float, alt_m: float = 0.0, mode: str = "AUTO") -> VehicleState:
    return VehicleState(time_s, 47.0, 8.0, alt_m, (0, 0, 0), None, mode, True)


AUTO = Heartbeat("AUTO", True)


def test_nothing_is_known_before_the_first_report() -> None:
    """Time and altitude are 0, and the vehicle is neither armed nor ready."""
    monitor = Scripted().monitor
    assert (monitor.time_s, monitor.altitude_m, monitor.mode, monitor.silence) == (0.0, 0.0, None, "")
    assert (monitor.armed, monitor.state, monitor.prearm) == (None, None, None)
    assert not monitor.may_be_armed
    assert not monitor.certainly_disarmed
    assert not monitor.unexpected_mode
    assert not monitor.mission_replaced
    assert monitor.caught_up


def test_reports_are_processed_one_at_a_time() -> None:
    """A step processes one, and fetches only when none is left."""
    scripted = Scripted()
    scripted.arrive(Heartbeat("GUIDED", False), state(1.0), PrearmStatus(True))
    monitor = scripted.monitor
    monitor.step(0.05)
    assert (monitor.mode, monitor.state, monitor.caught_up) == ("GUIDED", None, False)
    monitor.step(0.05)
    assert (monitor.time_s, monitor.prearm) == (1.0, None)
    monitor.step(0.05)
    assert (monitor.prearm, monitor.caught_up) == (PrearmStatus(True), True)
    assert scripted.timeouts_s == [0.05]


def test_catching_up_processes_all_that_has_arrived_without_waiting() -> None:
    """Later reports too, behind those that were waiting."""
    scripted = Scripted()
    scripted.arrive(Heartbeat("GUIDED", False), state(1.0))
    scripted.monitor.step()
    scripted.process(state(2.0), state(3.0))
    assert scripted.monitor.time_s == 3.0
    assert scripted.monitor.caught_up
    assert scripted.timeouts_s == [0.1, 0.0]


def test_a_lost_link_ends_the_flight_only_when_all_reports_are_processed() -> None:
    """Silence is measured between fetches, not while reports wait."""
    scripted = Scripted()
    scripted.clock.now_s += 31.0
    scripted.process(AUTO, AUTO)
    for _ in range(5):
        scripted.clock.now_s += 1.0
        scripted.monitor.step()
    assert scripted.events == [LinkLost(4.0)]
    assert scripted.monitor.silence == "no data for 5 s"
    with pytest.raises(FlightEnded, match="link to the vehicle lost: no data for 30 s") as end:
        for _ in range(26):
            scripted.clock.now_s += 1.0
            scripted.monitor.step()
    assert end.value.ended == "link lost"


@pytest.mark.parametrize(
    ("severity", "reason"), [(Severity.ERROR, True), (Severity.WARNING, True), (Severity.NOTICE, False)]
)
def test_a_warning_or_worse_is_a_reason(severity: Severity, reason: bool) -> None:
    """The latest one of the phase; every text is emitted."""
    scripted = Scripted()
    text = StatusText(severity, "EKF variance")
    monitor = scripted.process(text)
    assert monitor.reason == ("EKF variance" if reason else "")
    assert scripted.events == [text]
    monitor.begin_phase()
    assert monitor.reason == ""


@pytest.mark.parametrize(
    ("text", "explains"),
    [
        ("Battery Failsafe", True),
        ("Fence Breached", True),
        ("Crash: Disarming", True),
        ("Mission: 3 WP", False),
    ],
)
def test_the_texts_that_explain_a_failsafe(text: str, explains: bool) -> None:
    """With one of them two heartbeats of RTL are enough, whatever its severity; without, three."""
    scripted = Scripted()
    scripted.monitor.modes.expect("AUTO")
    scripted.process(AUTO, state(50.0), StatusText(Severity.INFO, text), Heartbeat("RTL", True))
    if not explains:
        scripted.process(Heartbeat("RTL", True))
    with pytest.raises(FlightEnded) as end:
        scripted.process(Heartbeat("RTL", True))
    assert end.value.ended == "failsafe"
    assert (f"changed to RTL by itself: {text};" in end.value.problem) is explains


@pytest.mark.parametrize(("age_s", "explains"), [(10.0, True), (10.1, False)])
def test_a_failsafe_text_explains_for_ten_seconds(age_s: float, explains: bool) -> None:
    """Of vehicle time."""
    scripted = Scripted()
    scripted.monitor.modes.expect("AUTO")
    scripted.process(AUTO, state(50.0), StatusText(Severity.INFO, "Radio Failsafe"), state(50.0 + age_s))
    with pytest.raises(FlightEnded) as end:
        scripted.process(*[Heartbeat("RTL", True)] * 3)
    assert ("Radio Failsafe" in end.value.problem) is explains


def test_a_pilots_mode_ends_the_flight_as_such() -> None:
    """A failsafe text does not make LOITER the vehicle's choice."""
    scripted = Scripted()
    scripted.monitor.modes.expect("AUTO")
    scripted.process(AUTO, state(50.0), StatusText(Severity.INFO, "Radio Failsafe"))
    with pytest.raises(FlightEnded, match="changed to LOITER by the pilot or another ground station") as end:
        scripted.process(*[Heartbeat("LOITER", True)] * 2)
    assert end.value.ended == "pilot"


def test_a_reboot_ends_the_flight() -> None:
    """At once."""
    with pytest.raises(FlightEnded, match="the autopilot rebooted") as end:
        Scripted().process(Rebooted())
    assert end.value.ended == "reboot"


def test_an_uploaded_mission_is_noticed_by_its_text() -> None:
    """ArduCopter's, in any case; other texts do not count."""
    scripted = Scripted()
    assert not scripted.process(StatusText(Severity.INFO, "Mission: 1 WP")).mission_replaced
    assert scripted.process(StatusText(Severity.INFO, "Flight plan received")).mission_replaced
    assert scripted.process(StatusText(Severity.INFO, "Mission: 2 WP")).mission_replaced


def test_vehicle_time_counts_while_the_link_is_up() -> None:
    """Between positions less than a second of wall-clock time apart; a clock that goes back counts as 0."""
    scripted = Scripted()
    for wall_s, time_s in ((0.0, 50.0), (0.9, 54.0), (1.0, 60.0), (0.5, 59.0), (0.5, 61.0)):
        scripted.clock.now_s += wall_s
        scripted.process(state(time_s))
    assert scripted.monitor.link_up_s == 4.0 + 2.0


REFUSED, ACCEPTED = RequestAck(Request.ARM, False, "failed"), RequestAck(Request.ARM, True)


@pytest.mark.parametrize(
    ("reports", "may_be_armed"),
    [
        ([], True),
        ([ACCEPTED], True),
        ([REFUSED], False),
        ([Heartbeat("GUIDED", False)], True),
        ([REFUSED, Heartbeat("GUIDED", True)], True),
        ([ACCEPTED, Heartbeat("GUIDED", True), Heartbeat("GUIDED", False)], False),
    ],
    ids=["no ack", "accepted", "refused", "not shown yet", "armed after all", "disarmed again"],
)
def test_a_vehicle_may_be_armed_from_the_request_on(reports: list[Report], may_be_armed: bool) -> None:
    """Until a refusal, or until heartbeats showed it armed and then disarmed."""
    scripted = Scripted()
    scripted.monitor.begin_arming()
    assert scripted.process(*reports).may_be_armed is may_be_armed


def test_a_vehicle_that_others_armed_is_not_ours() -> None:
    """It is armed, but not at our request."""
    monitor = Scripted().process(Heartbeat("GUIDED", True))
    assert monitor.armed
    assert not monitor.was_armed
    assert not monitor.may_be_armed


def test_a_new_arming_is_not_the_one_before() -> None:
    """That the vehicle was armed before does not count any more."""
    scripted = Scripted()
    scripted.monitor.begin_arming()
    scripted.process(Heartbeat("GUIDED", True), Heartbeat("GUIDED", False))
    scripted.monitor.begin_arming()
    assert scripted.monitor.may_be_armed


@pytest.mark.parametrize("entered", [AUTO, RequestAck(Request.MODE, True)], ids=["heartbeat", "ack"])
def test_auto_begins_with_its_heartbeat_or_its_ack(entered: Report) -> None:
    """From then on positions are recorded; only once AUTO was requested."""
    scripted = Scripted()
    scripted.process(state(50.0), entered, state(51.0))
    assert scripted.monitor.auto_start_s is None
    scripted.monitor.record_auto(route(10))
    scripted.process(state(52.0), entered, state(53.0), entered, state(54.0))
    assert scripted.monitor.auto_start_s == 52.0
    assert [position.time_s for position in scripted.monitor.flown] == [53.0, 54.0]


@pytest.mark.parametrize("ack", [RequestAck(Request.MODE, False), ACCEPTED], ids=["refused", "of arming"])
def test_other_acks_do_not_begin_auto(ack: RequestAck) -> None:
    """Only the accepted mode does."""
    scripted = Scripted()
    scripted.monitor.record_auto(route(10))
    assert scripted.process(ack, Heartbeat("GUIDED", True)).auto_start_s is None


def test_items_reached_before_auto_do_not_count() -> None:
    """They are of a mission flown before."""
    scripted = Scripted()
    scripted.process(state(50.0), MissionItemReached(7), MissionCurrent(8, 10))
    scripted.monitor.record_auto(route(10))
    assert scripted.monitor.progress.reached == {}
    assert scripted.monitor.mission == MissionCurrent(0)
    scripted.process(MissionCurrent(4, 10))
    assert scripted.monitor.progress.reached == {}
    assert scripted.monitor.mission == MissionCurrent(0)


def test_an_item_is_reached_once_with_all_before_it() -> None:
    """By its own report, or because the vehicle flies to the next one; at the time of the report."""
    scripted = Scripted()
    scripted.monitor.record_auto(route(10))
    scripted.process(state(50.0), AUTO, MissionCurrent(1, 5))
    assert scripted.monitor.progress.reached == {}
    scripted.process(
        state(51.0), MissionItemReached(2), state(52.0), MissionCurrent(3, 5), MissionCurrent(4, 5)
    )
    assert scripted.monitor.progress.reached == {1: 51.0, 2: 51.0, 3: 52.0}
    scripted.process(state(53.0), MissionCurrent(4, 5, complete=True))
    assert scripted.monitor.progress.reached == {1: 51.0, 2: 51.0, 3: 52.0, 4: 53.0}
    reached = [event for event in scripted.events if isinstance(event, WaypointReached)]
    reached_s = scripted.monitor.progress.reached
    assert reached == [WaypointReached(seq, reached_s[seq], seq) for seq in (1, 2, 3, 4)]


def test_of_turns_and_speed_changes_no_waypoint_is_told() -> None:
    """They are read long before a turn is made; waypoints are counted without them."""
    first, second = route(2).items
    turn = MissionItem(Command.CONDITION_YAW, Frame.RELATIVE, (90.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0)
    scripted = Scripted()
    scripted.monitor.record_auto(Mission((first, turn, turn, second)))
    scripted.process(state(50.0), AUTO, MissionCurrent(4, 5), state(60.0), MissionItemReached(4))
    reached = [event for event in scripted.events if isinstance(event, WaypointReached)]
    assert reached == [WaypointReached(1, 50.0, 1), WaypointReached(4, 60.0, 2)]


@pytest.mark.parametrize("heard", [[AUTO, MissionCurrent(1, 10)], []], ids=["in AUTO", "before AUTO"])
def test_what_was_flown_in_a_silence_is_no_jump(heard: list[Report]) -> None:
    """The first number behind it waits for the position that follows, 100 m on; AUTO may begin within it."""
    scripted = Scripted()
    scripted.monitor.record_auto(route(20))
    scripted.process(state(50.0), Heartbeat("GUIDED", True), *heard)
    scripted.clock.now_s += 6.0
    entered: list[Report] = [] if heard else [state(55.8), AUTO]
    monitor = scripted.process(*entered, MissionCurrent(11, 20))
    scripted.process(replace(state(56.0), lat_deg=47.0 + 9e-4), MissionCurrent(11, 20))
    assert (monitor.progress.jumps, monitor.mission) == ([], MissionCurrent(11, 20))
    assert sorted(monitor.progress.reached) == list(range(1, 11))


def test_a_lost_request_fails_with_the_next_heartbeat() -> None:
    """Which shows that it was not done."""
    scripted = Scripted()
    assert not scripted.process(RequestLost(Request.MODE)).requests.failed(Request.MODE)
    assert scripted.process(Heartbeat("GUIDED", False)).requests.failed(Request.MODE)


def test_an_unknown_report_is_a_bug() -> None:
    """It is not ignored."""
    with pytest.raises(TypeError, match="unknown report: 'hello'"):
        Scripted().process("hello")  # type: ignore[arg-type]
