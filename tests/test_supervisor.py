"""The supervisor: phases, deadlines, and the promise that what is in the air is sent home."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from fake_vehicle import FakeClock, FakeVehicle, route

from flight_replay import events
from flight_replay.errors import PhaseTimeoutError, VehicleError
from flight_replay.events import Event
from flight_replay.mission import Mission, change_speed, waypoint
from flight_replay.supervisor import Deadlines, FlightRecord, Plan, fly
from flight_replay.supervisor.contract import Heartbeat, MissionAt, News, Rebooted, Request, Unanswered

Setup = Callable[[FakeVehicle], None]


class Flown:
    """A flight of a fake vehicle: its record, what was emitted and what was asked."""

    def __init__(self, vehicle: FakeVehicle, **plan: object) -> None:
        self.vehicle = vehicle
        self.events: list[Event] = []
        self.plan = Plan(mission=route(vehicle.points), **plan)  # type: ignore[arg-type]
        self.began_s = vehicle.clock.now_s

    def fly(self) -> FlightRecord:
        return fly(self.vehicle, self.vehicle.clock, self.plan, self.events.append)

    def of(self, kind: type) -> list[Event]:
        """The events of one kind."""
        return [event for event in self.events if isinstance(event, kind)]

    @property
    def wall_s(self) -> float:
        """How long it took by the clock here."""
        return self.vehicle.clock.now_s - self.began_s


def flown(vehicle: FakeVehicle | None = None, **plan: object) -> Flown:
    return Flown(vehicle or FakeVehicle(FakeClock()), **plan)


def test_a_good_flight_asks_each_step_once_in_order() -> None:
    """GUIDED, the mission checked, arm, take-off, checked again, AUTO, RTL: each asked once."""
    flight = flown(FakeVehicle(FakeClock(), points=40))
    record = flight.fly()
    asked = [word for word in flight.vehicle.asked if word != "report"]
    assert asked == ["GUIDED", "verify", "arm", "takeoff", "verify", "AUTO", "RTL"]
    assert record.problem is None
    assert record.rtl_confirmed


def test_a_timed_flight_ends_after_its_duration() -> None:
    """60 s of AUTO by the vehicle's clock, and the waypoints reached by then are counted."""
    record = flown(FakeVehicle(FakeClock(), points=40)).fly()
    assert record.ended == "duration"
    assert record.auto_s == pytest.approx(60, abs=0.3)
    assert record.waypoints_reached == 15
    assert [seq for seq, _ in record.reached] == list(range(1, 16))
    times_s = [time_s - record.auto_start_s for _, time_s in record.reached]
    assert times_s == pytest.approx([4.0 * n for n in range(1, 16)], abs=0.3)


@pytest.mark.parametrize("speedup", [0.5, 1.0, 20.0])
def test_the_speed_of_the_vehicles_clock_changes_nothing(speedup: float) -> None:
    """A simulator that runs faster or slower than time here flies the same 60 s."""
    record = flown(FakeVehicle(FakeClock(), speedup=speedup, points=40)).fly()
    assert record.auto_s == pytest.approx(60, abs=2.5)
    assert record.problem is None


def test_a_timed_flight_ends_when_heading_for_the_final_waypoint() -> None:
    """As in DroneKit's example, heading for the last one ends it; the one before was reached."""
    record = flown().fly()
    assert (record.ended, record.waypoints_reached) == ("final waypoint", 4)


def test_a_whole_flight_reaches_the_last_waypoint() -> None:
    """``duration_s=None`` follows until the last waypoint is reached."""
    record = flown(duration_s=None).fly()
    assert (record.ended, record.waypoints_reached, record.problem) == ("mission complete", 5, None)
    assert record.auto_s == pytest.approx(20, abs=1.5)


def test_reached_waypoints_do_not_depend_on_the_reports_arriving() -> None:
    """Where every MISSION_ITEM_REACHED is lost, MISSION_CURRENT tells."""
    vehicle = FakeVehicle(FakeClock(), reports_reached=False)
    assert flown(vehicle, duration_s=None).fly().waypoints_reached == 5


def test_the_flown_track_is_what_was_reported_in_auto() -> None:
    """The record's track begins with AUTO, ends with it, and moves north."""
    record = flown().fly()
    assert record.flown.time_s[0] >= record.auto_start_s
    assert record.flown.time_s[-1] - record.auto_start_s == pytest.approx(record.auto_s, abs=0.2)
    assert record.flown.lat_deg[-1] > record.flown.lat_deg[0]


def test_takeoff_is_done_at_95_percent() -> None:
    """The climb is told once a second against 28.5 m, and the mission starts above that."""
    flight = flown()
    flight.fly()
    climbs = flight.of(events.Climbing)
    assert 10 <= len(climbs) <= 14
    assert {event.enough_m for event in climbs if isinstance(event, events.Climbing)} == {28.5}
    assert flight.of(events.TargetAltitudeReached) == [events.TargetAltitudeReached(30.0)]


def test_landing_is_awaited_when_asked_for() -> None:
    """``land`` follows the vehicle until it has disarmed on the ground."""
    flight = flown(land=True)
    assert flight.fly().landed
    assert not flight.vehicle.armed


def test_an_arming_that_shows_late_is_not_asked_twice() -> None:
    """ArduCopter 3.3 arms after 3 s, and starts over when asked again."""
    flight = flown(FakeVehicle(FakeClock(), arm_delay_s=3.0))
    flight.fly()
    assert flight.vehicle.asked.count("arm") == 1


def never_ready(vehicle: FakeVehicle) -> None:
    vehicle.ready_after_s = 1e9
    vehicle.at.append((5.0, lambda: vehicle.say("PreArm: Compass not calibrated")))


def arming_refused(vehicle: FakeVehicle) -> None:
    vehicle.refuse_arm = "Arm: Throttle too high"


def guided_refused(vehicle: FakeVehicle) -> None:
    vehicle.refuse_mode = frozenset({"GUIDED"})


def auto_refused(vehicle: FakeVehicle) -> None:
    vehicle.refuse_mode = frozenset({"AUTO"})


def no_climb(vehicle: FakeVehicle) -> None:
    vehicle.climbs = False


def wrong_mission(vehicle: FakeVehicle) -> None:
    vehicle.verified = False


FAILURES: list[tuple[Setup, type[Exception], str, bool]] = [
    (never_ready, PhaseTimeoutError, "Compass not calibrated", False),
    (arming_refused, PhaseTimeoutError, "Throttle too high", False),
    (guided_refused, PhaseTimeoutError, "did not change to mode GUIDED", False),
    (auto_refused, PhaseTimeoutError, 'mode AUTO within 15 s: it says "FAILED"', True),
    (no_climb, PhaseTimeoutError, "stayed at 0.0 m", True),
    (wrong_mission, VehicleError, "another station changed it", False),
]


@pytest.mark.parametrize(
    ("setup", "kind", "words", "armed"), FAILURES, ids=lambda x: getattr(x, "__name__", None)
)
def test_a_phase_that_fails_names_the_reason(
    setup: Setup, kind: type[Exception], words: str, armed: bool
) -> None:
    """Each deadline ends in one sentence with the autopilot's words; RTL is commanded if it is armed."""
    flight = flown()
    setup(flight.vehicle)
    with pytest.raises(kind, match=words):
        flight.fly()
    assert ("RTL" in flight.vehicle.asked) is armed
    assert flight.of(events.ReturnCommanded) == ([events.ReturnCommanded(True)] if armed else [])
    assert flight.wall_s < 250


def test_an_armed_vehicle_is_left_alone() -> None:
    """A vehicle that somebody else flies is neither taken nor sent home."""
    flight = flown()
    flight.vehicle.armed, flight.vehicle.mode = True, "LOITER"
    with pytest.raises(VehicleError, match="armed already, in mode LOITER"):
        flight.fly()
    assert flight.vehicle.asked == []


def test_a_vehicle_that_somebody_else_arms_is_not_taken_off_with() -> None:
    """What was not armed from here is neither flown nor sent home."""
    flight = flown(FakeVehicle(FakeClock()))
    vehicle = flight.vehicle

    def armed_meanwhile(attend: Callable[[], None]) -> bool:
        vehicle.queue.append(Heartbeat("GUIDED", True))
        attend()
        return True

    vehicle.mission_verified = armed_meanwhile  # type: ignore[method-assign]
    with pytest.raises(VehicleError, match="armed already, in mode GUIDED"):
        flight.fly()
    assert vehicle.asked == ["GUIDED"]


def test_a_vehicle_armed_before_it_enters_guided_is_not_asked_again() -> None:
    """GUIDED is not asked for over the head of somebody who armed it in another mode."""
    flight = flown(FakeVehicle(FakeClock(), refuse_mode=frozenset({"GUIDED"})))
    flight.vehicle.at.append((6.0, lambda: setattr(flight.vehicle, "armed", True)))
    with pytest.raises(VehicleError, match="armed already, in mode STABILIZE"):
        flight.fly()
    assert flight.wall_s < 9


@pytest.mark.parametrize("when_s", [6.0, 12.0, 20.0, 30.0])
def test_ctrl_c_sends_the_vehicle_home(when_s: float) -> None:
    """An interrupt in the air commands RTL first, says that it is confirmed, and goes on up."""
    flight = flown(FakeVehicle(FakeClock(), points=40))

    def interrupt() -> None:
        raise KeyboardInterrupt

    flight.vehicle.at.append((when_s, interrupt))
    with pytest.raises(KeyboardInterrupt):
        flight.fly()
    assert flight.vehicle.mode == "RTL"
    assert flight.of(events.ReturnCommanded) == [events.ReturnCommanded(True)]
    assert flight.wall_s < when_s + 10


def test_an_interrupt_before_arming_commands_nothing() -> None:
    """Nothing was armed, so nothing is sent home."""
    flight = flown()

    def interrupt() -> None:
        raise KeyboardInterrupt

    flight.vehicle.at.append((1.0, interrupt))
    with pytest.raises(KeyboardInterrupt):
        flight.fly()
    assert "RTL" not in flight.vehicle.asked


@pytest.mark.parametrize("mode", ["LOITER", "STABILIZE", "POSHOLD"])
def test_a_pilot_who_takes_over_is_let_be(mode: str) -> None:
    """A mode that we did not ask for ends the flight, without RTL or AUTO being asked again."""
    flight = flown(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.at.append((30.0, lambda: setattr(flight.vehicle, "mode", mode)))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("pilot", False)
    assert mode in (record.problem or "")
    assert flight.vehicle.asked[-1] == "AUTO"


def test_a_pilot_who_takes_over_during_takeoff_ends_the_flight() -> None:
    """Before AUTO it is an error, and still nothing more is commanded."""
    flight = flown()
    flight.vehicle.at.append((8.0, lambda: setattr(flight.vehicle, "mode", "ALT_HOLD")))
    with pytest.raises(VehicleError, match="ALT_HOLD by somebody else"):
        flight.fly()
    assert flight.vehicle.asked[-1] == "takeoff"


def test_one_late_heartbeat_is_no_takeover() -> None:
    """A heartbeat from before the mode change that arrives after it changes nothing."""
    flight = flown(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.at.append((30.0, lambda: flight.vehicle.queue.append(Heartbeat("GUIDED", True))))
    assert flight.fly().ended == "duration"


@pytest.mark.parametrize(("mode", "home"), [("RTL", True), ("LAND", False)])
def test_a_failsafe_is_accepted_and_told(mode: str, home: bool) -> None:
    """RTL or LAND by the vehicle itself is reported with its reason, and not overruled."""
    flight = flown(FakeVehicle(FakeClock(), points=40))

    def failsafe() -> None:
        flight.vehicle.say("Battery Failsafe")
        flight.vehicle.mode = mode

    flight.vehicle.at.append((30.0, failsafe))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("failsafe", home)
    assert "Battery Failsafe" in (record.problem or "")
    assert flight.vehicle.asked[-1] == "AUTO"


def test_a_link_that_comes_back_is_used_again() -> None:
    """12 s of silence are told within 5 s, and the flight ends as asked."""
    flight = flown(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.at += [
        (30.0, lambda: setattr(flight.vehicle, "silent", True)),
        (42.0, lambda: setattr(flight.vehicle, "silent", False)),
    ]
    record = flight.fly()
    assert (record.ended, record.problem) == ("duration", None)
    (lost,), (back,) = flight.of(events.LinkLost), flight.of(events.LinkBack)
    assert isinstance(lost, events.LinkLost) and isinstance(back, events.LinkBack)
    assert lost.silent_s < 5 < back.silent_s


def test_a_link_lost_for_ever_ends_with_what_is_known() -> None:
    """After the time allowed, RTL is tried into the void and the record says what happened."""
    flight = flown(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.at.append((30.0, lambda: setattr(flight.vehicle, "silent", True)))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("link lost", False)
    assert record.waypoints_reached > 0
    assert flight.vehicle.asked[-1] == "RTL"
    assert flight.wall_s < 30 + 30 + 10


def test_a_reboot_in_the_air_ends_the_flight() -> None:
    """Whatever was known before is void; RTL is asked of what is left."""
    flight = flown(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.at.append((30.0, lambda: flight.vehicle.queue.append(Rebooted())))
    record = flight.fly()
    assert record.ended == "reboot"
    assert "RTL" in flight.vehicle.asked


def test_a_reboot_on_the_ground_is_an_error() -> None:
    """Before arming nothing is commanded any more."""
    flight = flown()
    flight.vehicle.at.append((2.0, lambda: flight.vehicle.queue.append(Rebooted())))
    with pytest.raises(VehicleError, match="rebooted"):
        flight.fly()
    assert "RTL" not in flight.vehicle.asked


def test_a_mission_that_changes_in_flight_is_left() -> None:
    """Another count of items on board than at the start ends AUTO with RTL."""
    flight = flown(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.at.append((30.0, lambda: flight.vehicle.queue.append(MissionAt(3, 7))))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("mission changed", True)


def test_a_mission_of_the_same_length_uploaded_in_flight_is_left() -> None:
    """The count does not show it, but the vehicle's words do: nothing unverified is flown on."""
    flight = flown(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.at.append((2.0, lambda: flight.vehicle.say("Flight plan received", 6)))
    flight.vehicle.at.append((30.0, lambda: flight.vehicle.say("Flight plan received", 6)))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("mission changed", True)
    assert record.auto_s < 30


def test_a_vehicle_that_stops_on_its_way_is_sent_home() -> None:
    """No progress for a minute ends a flight that has no duration."""
    flight = flown(FakeVehicle(FakeClock(), item_s=1e9), duration_s=None)
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("no progress", True)


def test_rtl_that_is_refused_is_a_problem() -> None:
    """A vehicle that does not confirm RTL leaves the record with a problem."""
    flight = flown(FakeVehicle(FakeClock(), points=40, refuse_mode=frozenset({"RTL"})))
    record = flight.fly()
    assert not record.rtl_confirmed
    assert "did not confirm RTL" in (record.problem or "")


def test_a_clock_that_stands_still_does_not_hold_the_wait() -> None:
    """A vehicle whose time never moves is given up by the clock here."""
    flight = flown(FakeVehicle(FakeClock(), reports_clock=False), deadlines=Deadlines(prearm_s=20))
    with pytest.raises(PhaseTimeoutError, match="not ready to arm within 20 s"):
        flight.fly()
    assert flight.wall_s < 70


def test_a_listener_that_fails_does_not_keep_the_vehicle_in_the_air() -> None:
    """A closed pipe (``flight-replay | head``) ends the program, but first the flight."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    plan = Plan(mission=route(vehicle.points))

    def listener(event: Event) -> None:
        if vehicle.mode == "AUTO" or "RTL" in vehicle.asked:
            raise BrokenPipeError

    with pytest.raises(BrokenPipeError):
        fly(vehicle, vehicle.clock, plan, listener)
    assert vehicle.mode == "RTL"


def test_a_vehicle_that_disarms_on_the_ground_is_armed_again() -> None:
    """ArduCopter disarms itself after 10 s on the ground, which a slow link can take."""
    flight = flown(FakeVehicle(FakeClock(), points=40, climbs=False))

    def disarm() -> None:
        flight.vehicle.armed, flight.vehicle.climbs = False, True

    flight.vehicle.at.append((16.0, disarm))
    assert flight.fly().problem is None
    assert flight.vehicle.asked.count("arm") == 2


def test_a_vehicle_that_keeps_disarming_is_given_up() -> None:
    """Three times is enough; nothing is left to be sent home."""
    flight = flown(FakeVehicle(FakeClock(), points=40, climbs=False))
    for second in range(16, 90, 11):
        flight.vehicle.at.append((second, lambda: setattr(flight.vehicle, "armed", False)))
    with pytest.raises(VehicleError, match="disarmed before it climbed"):
        flight.fly()
    assert flight.vehicle.asked.count("arm") == 3
    assert "RTL" not in flight.vehicle.asked


def test_a_vehicle_that_somebody_disarms_is_not_armed_again() -> None:
    """Before it lifts off, somebody may have walked up to it and stopped its motors."""
    flight = flown(FakeVehicle(FakeClock(), points=40, climbs=False))
    flight.vehicle.at.append((6.0, lambda: setattr(flight.vehicle, "armed", False)))
    with pytest.raises(VehicleError, match="disarmed by somebody else before it climbed"):
        flight.fly()
    assert flight.vehicle.asked.count("arm") == 1
    assert "RTL" not in flight.vehicle.asked


def test_a_vehicle_that_falls_while_it_climbs_is_not_armed_again() -> None:
    """A crash at 15 m is no vehicle that waited too long on the ground."""
    flight = flown(FakeVehicle(FakeClock(), points=40))

    def crash() -> None:
        flight.vehicle.say("Crash: Disarming")
        flight.vehicle.armed, flight.vehicle.altitude_m = False, 0.0

    flight.vehicle.at.append((12.0, crash))
    with pytest.raises(VehicleError, match=r"climbed to \d+\.\d m: it says \"Crash: Disarming\""):
        flight.fly()
    assert flight.vehicle.asked.count("arm") == 1


def test_holds_in_the_mission_are_no_standstill() -> None:
    """A wait of two minutes at a waypoint is progress enough, and an item without a place has no distance."""
    flight = flown(FakeVehicle(FakeClock(), points=3, item_s=100.0), duration_s=None)
    items = (waypoint(47.0, 8.0, 30.0, hold_s=120), change_speed(3.0), waypoint(47.001, 8.0, 30.0))
    flight.plan = replace(flight.plan, mission=Mission(items))
    assert flight.fly().ended == "mission complete"
    distances = {
        event.seq: event.distance_m
        for event in flight.of(events.Heading)
        if isinstance(event, events.Heading)
    }
    assert distances[2] is None


def test_a_landing_that_does_not_end_is_told() -> None:
    """A vehicle that hangs in the air on its way down leaves the record with a problem."""
    flight = flown(FakeVehicle(FakeClock(), points=40), land=True)
    move = flight.vehicle._move
    flight.vehicle._move = lambda step_s: None if flight.vehicle.mode == "RTL" else move(step_s)  # type: ignore[method-assign]
    record = flight.fly()
    assert (record.rtl_confirmed, record.landed) == (True, False)
    assert "did not land and disarm" in (record.problem or "")


def test_a_vehicle_that_disarms_in_flight_is_no_success() -> None:
    """A crash ends the flight with the vehicle's words, though its mode still is AUTO."""
    flight = flown(FakeVehicle(FakeClock(), points=40))

    def crash() -> None:
        flight.vehicle.say("Crash: Disarming")
        flight.vehicle.armed = False

    flight.vehicle.at.append((30.0, crash))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("disarmed", False)
    assert "Crash: Disarming" in (record.problem or "")


def test_a_return_without_a_reason_is_told_as_what_it_is() -> None:
    """RTL that nobody here asked for, and that the vehicle did not explain."""
    flight = flown(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.at.append((30.0, lambda: setattr(flight.vehicle, "mode", "RTL")))
    assert "changed to RTL without being asked to from here" in (flight.fly().problem or "")


class Stalled(FakeVehicle):
    """A vehicle whose news waits while this program does not run: in AUTO, for ``stall_s`` at once."""

    stall_s = 0.0

    def ask_mode(self, mode: str) -> None:
        super().ask_mode(mode)
        if mode == "AUTO":
            end_s = self.clock.now_s + self.stall_s
            waiting: list[News] = []
            while self.clock.now_s < end_s:
                waiting += super().news(0.1)
            self.queue[:0] = waiting


@pytest.mark.parametrize(("mode", "ended"), [("RTL", "failsafe"), ("LOITER", "pilot")])
@pytest.mark.parametrize("stall_s", [3.0, 3.5, 4.0, 4.5, 5.0, 8.0])
def test_a_program_that_did_not_run_for_a_while_overrules_nobody(
    mode: str, ended: str, stall_s: float
) -> None:
    """AUTO, and another mode a second later, may be heard at once: AUTO is not asked for again."""
    vehicle = Stalled(FakeClock(), points=40)
    vehicle.stall_s = stall_s

    def change() -> None:
        vehicle.mode = mode

    ask_mode = vehicle.ask_mode

    def ask(wanted: str) -> None:
        if wanted == "AUTO":
            vehicle.at.append((vehicle.clock.now_s - vehicle.began_s + 2.0, change))
        ask_mode(wanted)

    vehicle.ask_mode = ask  # type: ignore[method-assign,assignment]
    flight = flown(vehicle)
    assert flight.fly().ended == ended
    assert vehicle.asked.count("AUTO") == 1
    assert "RTL" not in vehicle.asked


def test_a_pilot_who_takes_over_while_the_mission_is_verified_is_let_be() -> None:
    """Reading takes seconds on a slow link; AUTO is not asked for over the pilot's choice."""

    class SlowReader(FakeVehicle):
        def mission_verified(self, attend: Callable[[], None]) -> bool:
            if self.altitude_m > 1:
                self.mode = "LOITER"
            for _ in range(30):
                self.clock.now_s += 0.1
                attend()
            return True

    flight = flown(SlowReader(FakeClock()))
    with pytest.raises(VehicleError, match="LOITER by somebody else"):
        flight.fly()
    assert not {"AUTO", "RTL"} & set(flight.vehicle.asked)


def test_one_heartbeat_of_another_mode_holds_commands_back() -> None:
    """A pilot's choice just before the top of the climb: AUTO waits until it is certain what it was."""
    flight = flown()
    vehicle = flight.vehicle
    move = vehicle._move

    def moved(step_s: float) -> None:
        move(step_s)
        if vehicle.mode == "GUIDED" and vehicle.altitude_m > 28:
            vehicle.mode = "POSHOLD"
            vehicle.altitude_m = 29.0
            vehicle.queue.append(Heartbeat("POSHOLD", True))

    vehicle._move = moved  # type: ignore[method-assign]
    with pytest.raises(VehicleError, match="POSHOLD by somebody else"):
        flight.fly()
    assert "AUTO" not in vehicle.asked


def test_a_pilot_who_takes_over_on_the_way_home_is_let_be() -> None:
    """RTL is not asked for again over the pilot's choice, and the problem names it."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def ask(mode: str) -> None:
        vehicle.asked.append(mode)
        vehicle.mode = "LOITER" if mode == "RTL" else mode

    vehicle.ask_mode = ask  # type: ignore[method-assign]
    flight = flown(vehicle)
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("duration", False)
    assert "LOITER by somebody else" in (record.problem or "")
    assert flight.of(events.ReturnCommanded) == [events.ReturnCommanded(False)]
    assert vehicle.asked.count("RTL") < 20


def test_a_pilot_who_chooses_before_ctrl_c_is_not_sent_home() -> None:
    """An interrupt between the first and the second heartbeat of the pilot's mode commands nothing."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def interrupt() -> None:
        vehicle.mode = "LOITER"
        vehicle.queue.append(Heartbeat("LOITER", True))
        vehicle.at.append((30.1, stop))

    def stop() -> None:
        raise KeyboardInterrupt

    vehicle.at.append((30.0, interrupt))
    flight = flown(vehicle)
    with pytest.raises(KeyboardInterrupt):
        flight.fly()
    assert "RTL" not in vehicle.asked


def test_words_behind_the_second_heartbeat_are_the_reason() -> None:
    """A mode change is told at once, its reason with the next packet; the second heartbeat may come first."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def failsafe() -> None:
        vehicle.mode = "RTL"
        vehicle.queue += [Heartbeat("RTL", True), Heartbeat("RTL", True)]
        vehicle.at.append((30.1, lambda: vehicle.say("Radio Failsafe")))

    vehicle.at.append((30.0, failsafe))
    assert "changed to RTL by itself: Radio Failsafe" in (flown(vehicle).fly().problem or "")


def test_words_of_long_ago_are_not_the_reason() -> None:
    """A failsafe that was told on the ground does not explain the pilot's RTL."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    vehicle.at += [
        (1.0, lambda: vehicle.say("PreArm: Radio failsafe on")),
        (30.0, lambda: setattr(vehicle, "mode", "RTL")),
    ]
    assert "without being asked to from here" in (flown(vehicle).fly().problem or "")


@pytest.mark.parametrize(("told", "again"), [(True, 1), (False, 0)])
def test_a_mode_is_asked_for_again_when_the_request_is_known_to_be_lost(told: bool, again: int) -> None:
    """Within 3 s only when the vehicle answered something later and its heartbeat shows the old mode."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    asked_s: list[float] = []

    def ask(mode: str) -> None:
        vehicle.asked.append(mode)
        if mode != "AUTO" or asked_s:
            vehicle.mode = mode
        if mode == "AUTO":
            asked_s.append(vehicle.time_s)
            if told:
                vehicle.queue.append(Unanswered(Request.MODE))

    vehicle.ask_mode = ask  # type: ignore[method-assign]
    assert flown(vehicle).fly().problem is None
    assert len(asked_s) == 2
    assert (asked_s[1] - asked_s[0] < 2.5) is bool(again)


def test_a_reboot_is_not_taken_for_a_pilot_before_the_clock_is_heard() -> None:
    """Heartbeats come at once after a reboot, the clock only when it was asked for again."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def reboot() -> None:
        vehicle.mode, vehicle.armed, vehicle.reports_clock = "STABILIZE", False, False
        vehicle.at.append((34.0, lambda: vehicle.queue.append(Rebooted())))

    vehicle.at.append((30.0, reboot))
    assert flown(vehicle).fly().ended == "reboot"


def test_a_pilot_who_changes_the_mode_and_disarms_is_told_from_a_reboot() -> None:
    """The vehicle's clock goes on."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def take() -> None:
        vehicle.mode, vehicle.armed = "STABILIZE", False

    vehicle.at.append((30.0, take))
    assert flown(vehicle).fly().ended in ("pilot", "disarmed")


def test_a_disarmed_vehicle_that_never_tells_its_clock_is_not_waited_for() -> None:
    """Some seconds of heartbeats without a clock are enough."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def fall() -> None:
        vehicle.armed, vehicle.reports_clock = False, False

    vehicle.at.append((30.0, fall))
    flight = flown(vehicle)
    assert flight.fly().ended == "disarmed"
    assert flight.wall_s < 45
