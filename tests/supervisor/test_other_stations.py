"""Pilots, failsafes and other ground stations keep control: the supervisor does not overrule them."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import pytest

from flight_replay import events
from flight_replay.exceptions import VehicleError
from flight_replay.supervisor import fly
from flight_replay.supervisor.vehicle_interface import Heartbeat, Rebooted, Report, Request, RequestLost
from tests.helpers.fake_vehicle import FakeClock, FakeVehicle
from tests.helpers.supervised import FakeFlight, fake_flight, fake_following


def test_an_armed_vehicle_is_left_alone() -> None:
    """A vehicle that somebody else flies gets neither take-off nor RTL."""
    flight = fake_flight()
    flight.vehicle.armed, flight.vehicle.mode = True, "LOITER"
    with pytest.raises(VehicleError, match="already armed, in mode LOITER"):
        flight.fly()
    assert flight.vehicle.requested == []


def test_a_vehicle_armed_by_somebody_else_is_not_flown() -> None:
    """It gets neither take-off nor RTL."""
    flight = fake_flight(FakeVehicle(FakeClock()))
    vehicle = flight.vehicle

    def armed_meanwhile(while_waiting: Callable[[], None]) -> bool:
        vehicle.queue.append(Heartbeat("GUIDED", True))
        while_waiting()
        return True

    vehicle.mission_verified = armed_meanwhile  # type: ignore[method-assign]
    with pytest.raises(VehicleError, match="already armed, in mode GUIDED"):
        flight.fly()
    assert vehicle.requested == ["GUIDED"]


def test_guided_is_not_requested_of_a_vehicle_armed_by_somebody_else() -> None:
    """Whoever armed it in another mode has control."""
    flight = fake_flight(FakeVehicle(FakeClock(), refuse_mode=frozenset({"GUIDED"})))
    flight.vehicle.schedule.append((6.0, lambda: setattr(flight.vehicle, "armed", True)))
    with pytest.raises(VehicleError, match="already armed, in mode STABILIZE"):
        flight.fly()
    assert flight.wall_s < 9


@pytest.mark.parametrize("mode", ["LOITER", "STABILIZE", "POSHOLD"])
def test_a_pilot_who_changes_the_mode_keeps_control(mode: str) -> None:
    """The flight ends, without another request for RTL or AUTO."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.schedule.append((30.0, lambda: setattr(flight.vehicle, "mode", mode)))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("pilot", False)
    assert mode in (record.problem or "")
    assert flight.vehicle.requested[-1] == "AUTO"


def test_a_pilot_who_takes_over_during_takeoff_ends_the_flight() -> None:
    """Before AUTO it is an error, and nothing more is commanded."""
    flight = fake_flight()
    flight.vehicle.schedule.append((8.0, lambda: setattr(flight.vehicle, "mode", "ALT_HOLD")))
    with pytest.raises(VehicleError, match="ALT_HOLD by the pilot"):
        flight.fly()
    assert flight.vehicle.requested[-1] == "takeoff"


def test_one_late_heartbeat_is_not_a_mode_change() -> None:
    """A heartbeat from before the mode change that arrives after it changes nothing."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.schedule.append((30.0, lambda: flight.vehicle.queue.append(Heartbeat("GUIDED", True))))
    assert flight.fly().ended == "duration"


@pytest.mark.parametrize(("mode", "home"), [("RTL", True), ("LAND", False)])
def test_a_failsafe_keeps_control(mode: str, home: bool) -> None:
    """RTL or LAND by the vehicle itself is a problem with its reason, and not overruled."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))

    def failsafe() -> None:
        flight.vehicle.send_text("Battery Failsafe")
        flight.vehicle.mode = mode

    flight.vehicle.schedule.append((30.0, failsafe))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("failsafe", home)
    assert "Battery Failsafe" in (record.problem or "")
    assert flight.vehicle.requested[-1] == "AUTO"


@pytest.mark.parametrize("mode", ["RTL", "LAND", "BRAKE", "SMART_RTL"])
def test_rtl_without_a_reason_is_reported_as_such(mode: str) -> None:
    """The pilot may have chosen it; a failsafe tells why, but that may be lost."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.schedule.append((30.0, lambda: setattr(flight.vehicle, "mode", mode)))
    record = flight.fly()
    now = "take control, the vehicle hovers there" if mode == "BRAKE" else "watch the vehicle"
    assert (record.ended, record.problem) == (
        "failsafe",
        f"the mode was changed to {mode} by the pilot, a failsafe or another ground station, and no reason "
        f"was given; flight-replay sends no more commands: {now}",
    )


def test_keeping_away_from_another_aircraft_is_the_vehicles_own_choice() -> None:
    """Whatever failsafe texts there are, it is neither the pilot's nor a failsafe's."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def avoid() -> None:
        vehicle.send_text("Radio Failsafe - Continuing Auto")
        vehicle.mode = "AVOID_ADSB"

    vehicle.schedule.append((30.0, avoid))
    record = fake_flight(vehicle).fly()
    assert (record.ended, record.problem) == (
        "failsafe",
        "the vehicle changed to AVOID_ADSB by itself, to keep away from another aircraft; "
        "flight-replay sends no more commands: watch the vehicle, it may fly on by itself",
    )
    assert "RTL" not in vehicle.requested


class Stalled(FakeVehicle):
    """A vehicle whose reports arrive all at once, ``stall_s`` after AUTO was requested."""

    stall_s = 0.0

    def request_mode(self, mode: str) -> None:
        super().request_mode(mode)
        if mode == "AUTO":
            end_s = self.clock.now_s + self.stall_s
            waiting: list[Report] = []
            while self.clock.now_s < end_s:
                waiting += super().reports(0.1)
            self.queue[:0] = waiting


@pytest.mark.parametrize(("mode", "ended"), [("RTL", "failsafe"), ("LOITER", "pilot")])
@pytest.mark.parametrize("stall_s", [3.0, 3.5, 4.0, 4.5, 5.0, 8.0])
def test_reports_that_arrive_at_once_are_processed_in_order(mode: str, ended: str, stall_s: float) -> None:
    """AUTO, and another mode seconds later: AUTO is not requested again."""
    vehicle = Stalled(FakeClock(), points=40)
    vehicle.stall_s = stall_s

    def change() -> None:
        vehicle.mode = mode

    request_mode = vehicle.request_mode

    def ask(wanted: str) -> None:
        if wanted == "AUTO":
            vehicle.schedule.append((vehicle.clock.now_s - vehicle.began_s + 2.0, change))
        request_mode(wanted)

    vehicle.request_mode = ask  # type: ignore[method-assign,assignment]
    flight = fake_flight(vehicle)
    assert flight.fly().ended == ended
    assert vehicle.requested.count("AUTO") == 1
    assert "RTL" not in vehicle.requested


def test_a_pilot_who_takes_over_during_verification_keeps_control() -> None:
    """The download takes seconds on a slow link; AUTO is not requested after it."""

    class SlowReader(FakeVehicle):
        def mission_verified(self, while_waiting: Callable[[], None]) -> bool:
            if self.altitude_m > 1:
                self.mode = "LOITER"
            for _ in range(30):
                self.clock.now_s += 0.1
                while_waiting()
            return True

    flight = fake_flight(SlowReader(FakeClock()))
    with pytest.raises(VehicleError, match="LOITER by the pilot"):
        flight.fly()
    assert not {"AUTO", "RTL"} & set(flight.vehicle.requested)


def test_one_heartbeat_of_another_mode_delays_requests() -> None:
    """A pilot's choice just before the top of the climb: AUTO waits for the next heartbeat."""
    flight = fake_flight()
    vehicle = flight.vehicle
    move = vehicle.move

    def moved(step_s: float) -> None:
        move(step_s)
        if vehicle.mode == "GUIDED" and vehicle.altitude_m > 28:
            vehicle.mode = "POSHOLD"
            vehicle.altitude_m = 29.0
            vehicle.queue.append(Heartbeat("POSHOLD", True))

    vehicle.move = moved  # type: ignore[method-assign]
    with pytest.raises(VehicleError, match="POSHOLD by the pilot"):
        flight.fly()
    assert "AUTO" not in vehicle.requested


def test_a_pilot_who_takes_over_during_rtl_keeps_control() -> None:
    """RTL is not requested again, and the problem names the mode."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def ask(mode: str) -> None:
        vehicle.requested.append(mode)
        vehicle.mode = "LOITER" if mode == "RTL" else mode

    vehicle.request_mode = ask  # type: ignore[method-assign]
    flight = fake_flight(vehicle)
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("duration", False)
    assert "LOITER by the pilot" in (record.problem or "")
    assert flight.of(events.ReturnCommanded) == [events.ReturnCommanded(False)]
    assert vehicle.requested.count("RTL") < 20


def test_ctrl_c_after_a_pilots_mode_change_commands_nothing() -> None:
    """Also between the first and the second heartbeat of the pilot's mode."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def interrupt() -> None:
        vehicle.mode = "LOITER"
        vehicle.queue.append(Heartbeat("LOITER", True))
        vehicle.schedule.append((30.1, stop))

    def stop() -> None:
        raise KeyboardInterrupt

    vehicle.schedule.append((30.0, interrupt))
    flight = fake_flight(vehicle)
    with pytest.raises(KeyboardInterrupt):
        flight.fly()
    assert "RTL" not in vehicle.requested


def test_a_status_text_after_the_second_heartbeat_is_the_reason() -> None:
    """The heartbeat with a failsafe's mode may come before the text that explains it."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def failsafe() -> None:
        vehicle.mode = "RTL"
        vehicle.queue += [Heartbeat("RTL", True), Heartbeat("RTL", True)]
        vehicle.schedule.append((30.1, lambda: vehicle.send_text("Radio Failsafe")))

    vehicle.schedule.append((30.0, failsafe))
    assert "changed to RTL by itself: Radio Failsafe" in (fake_flight(vehicle).fly().problem or "")


def test_an_old_status_text_is_not_the_reason() -> None:
    """A failsafe text from before the flight does not explain a later RTL."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    vehicle.schedule += [
        (1.0, lambda: vehicle.send_text("PreArm: Radio failsafe on")),
        (30.0, lambda: setattr(vehicle, "mode", "RTL")),
    ]
    assert "no reason was given" in (fake_flight(vehicle).fly().problem or "")


@pytest.mark.parametrize(("told", "again"), [(True, 1), (False, 0)])
def test_a_lost_mode_request_is_sent_again(told: bool, again: int) -> None:
    """Within 3 s only if it is known to be lost and the heartbeat shows the old mode."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    asked_s: list[float] = []

    def ask(mode: str) -> None:
        vehicle.requested.append(mode)
        if mode != "AUTO" or asked_s:
            vehicle.mode = mode
        if mode == "AUTO":
            asked_s.append(vehicle.time_s)
            if told:
                vehicle.queue.append(RequestLost(Request.MODE))

    vehicle.request_mode = ask  # type: ignore[method-assign]
    assert fake_flight(vehicle).fly().problem is None
    assert len(asked_s) == 2
    assert asked_s[1] - asked_s[0] == pytest.approx(1.2 if again else 3.0, abs=0.3)


def test_a_reboot_is_not_taken_for_a_pilot() -> None:
    """Heartbeats come at once after a reboot, the clock only after the streams are requested again."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def reboot() -> None:
        vehicle.mode, vehicle.armed, vehicle.reports_clock = "STABILIZE", False, False
        vehicle.schedule.append((34.0, lambda: vehicle.queue.append(Rebooted())))

    vehicle.schedule.append((30.0, reboot))
    assert fake_flight(vehicle).fly().ended == "reboot"


def test_a_pilot_who_changes_the_mode_and_disarms_is_not_a_reboot() -> None:
    """The vehicle's clock runs on."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def take() -> None:
        vehicle.mode, vehicle.armed = "STABILIZE", False

    vehicle.schedule.append((30.0, take))
    assert fake_flight(vehicle).fly().ended in ("pilot", "disarmed")


@pytest.mark.parametrize("mode", ["RTL", "LAND"])
def test_a_failsafe_in_auto_is_not_answered_with_rtl(mode: str) -> None:
    """The program neither commands RTL nor emits that it does."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def failsafe() -> None:
        vehicle.send_text("Radio Failsafe")
        vehicle.mode = mode

    vehicle.schedule.append((30.0, failsafe))
    flight = fake_flight(vehicle)
    flight.fly()
    assert flight.of(events.ReturnCommanded) == []
    assert events.PhaseStarted(events.Phase.RETURN) not in flight.events


@pytest.mark.parametrize(("mode", "words"), [("RTL", "by itself: Radio Failsafe"), ("LAND", "by itself")])
def test_a_failsafe_during_takeoff_is_not_answered_with_rtl(mode: str, words: str) -> None:
    """Before AUTO too, the failsafe keeps control."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def failsafe() -> None:
        vehicle.send_text("Radio Failsafe")
        vehicle.mode = mode

    vehicle.schedule.append((10.0, failsafe))
    flight = fake_flight(vehicle)
    with pytest.raises(VehicleError, match=words):
        flight.fly()
    assert flight.of(events.ReturnCommanded) == []
    assert events.PhaseStarted(events.Phase.RETURN) not in flight.events
    assert "RTL" not in vehicle.requested


def test_a_pilots_mode_change_starts_no_rtl_phase() -> None:
    """Neither in AUTO nor before."""
    for when_s in (10.0, 30.0):
        vehicle = FakeVehicle(FakeClock(), points=40)
        vehicle.schedule.append((when_s, lambda vehicle=vehicle: setattr(vehicle, "mode", "LOITER")))  # type: ignore[misc]
        flight = fake_flight(vehicle)
        with suppress(VehicleError):
            flight.fly()
        assert vehicle.mode == "LOITER"
        assert events.PhaseStarted(events.Phase.RETURN) not in flight.events


@pytest.mark.parametrize("heartbeats", [1, 3])
@pytest.mark.parametrize("mode", ["LAND", "BRAKE"])
def test_ctrl_c_on_the_way_home_does_not_overrule_another_mode(mode: str, heartbeats: int) -> None:
    """RTL was confirmed; since then a pilot or a failsafe chose another mode, which one heartbeat shows."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    request_mode = vehicle.request_mode

    def interrupt() -> None:
        raise KeyboardInterrupt

    def change() -> None:
        vehicle.mode = mode
        vehicle.queue += [Heartbeat(mode, True)] * heartbeats

    def request(wanted: str) -> None:
        request_mode(wanted)
        if wanted == "RTL":
            now_s = vehicle.clock.now_s - vehicle.began_s
            vehicle.schedule += [(now_s + 3.0, change), (now_s + 3.15, interrupt)]

    vehicle.request_mode = request  # type: ignore[method-assign,assignment]
    flight = fake_flight(vehicle, land=True)
    if mode == "BRAKE" and heartbeats == 3:
        assert "BRAKE" in (flight.fly().problem or ""), "it ended before Ctrl-C"
    else:
        with pytest.raises(KeyboardInterrupt):
            flight.fly()
        texts = [notice.text for notice in flight.of(events.Notice)]
        assert any(text.startswith(f"RTL became {mode}: ") for text in texts)
    assert (vehicle.requested.count("RTL"), vehicle.mode) == (1, mode)
    assert flight.of(events.ReturnCommanded) == [events.ReturnCommanded(True)]


@pytest.mark.parametrize(
    ("text", "ended", "words"),
    [
        ("EKF Failsafe: changed to ALT_HOLD Mode", "failsafe", "the vehicle changed to ALT_HOLD by itself"),
        ("GCS Failsafe - Continuing Auto Mode", "pilot", "changed to ALT_HOLD by the pilot"),
    ],
)
def test_a_failsafe_may_choose_a_pilots_mode(text: str, ended: str, words: str) -> None:
    """FS_EKF_ACTION 2 is ALT_HOLD; the text names the mode that a failsafe chose."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def change() -> None:
        vehicle.send_text(text, 2)
        vehicle.mode = "ALT_HOLD"

    vehicle.schedule.append((30.0, change))
    record = fake_flight(vehicle).fly()
    assert (record.ended, record.rtl_confirmed) == (ended, False)
    assert words in (record.problem or "")
    assert ("take control" in (record.problem or "")) is (ended == "failsafe")
    assert "RTL" not in vehicle.requested


@pytest.mark.parametrize(("modes", "text"), [(("RTL",), ""), (("RTL", "LAND"), "RTL became LAND: ")])
def test_ctrl_c_on_a_failsafes_way_home_commands_nothing(modes: tuple[str, ...], text: str) -> None:
    """With --land, after the program has said that it sends no more commands."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def failsafe(mode: str) -> None:
        vehicle.send_text(f"Battery Failsafe: changed to {mode} Mode")
        vehicle.mode = mode

    def interrupt() -> None:
        raise KeyboardInterrupt

    for number, mode in enumerate(modes):
        vehicle.schedule.append((30.0 + 3.0 * number, lambda mode=mode: failsafe(mode)))  # type: ignore[misc]
    vehicle.schedule.append((38.0, interrupt))
    flight = fake_flight(vehicle, land=True)
    with pytest.raises(KeyboardInterrupt):
        flight.fly()
    assert (vehicle.requested[-1], vehicle.mode) == ("AUTO", modes[-1])
    told = [notice.text for notice in flight.of(events.Notice)]
    assert told[-1].startswith(f"no RTL is commanded: somebody else chose the mode, which is {modes[-1]};")
    assert any(each.startswith(text) for each in told)
    assert flight.of(events.ReturnCommanded) == []


def test_a_listener_that_ends_the_program_does_not_overrule_a_pilot() -> None:
    """As Ctrl-C does that comes while it is told that the pilot took over."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    vehicle.schedule.append((30.0, lambda: setattr(vehicle, "mode", "LOITER")))

    def listen(event: events.Event) -> None:
        if isinstance(event, events.Notice):
            vehicle.silent = True
            raise KeyboardInterrupt

    flight = fake_flight(vehicle)
    with pytest.raises(KeyboardInterrupt):
        fly(vehicle, vehicle.clock, flight.plan, listen)
    assert (vehicle.requested[-1], vehicle.mode) == ("AUTO", "LOITER")


def one_heartbeat_then_silence(vehicle: FakeVehicle, when_s: float) -> None:
    """A pilot takes over, which one heartbeat tells; from then on the vehicle hears, and is not heard."""

    def take() -> None:
        vehicle.mode = "LOITER"
        vehicle.queue.append(Heartbeat("LOITER", True))

    vehicle.schedule += [(when_s, take), (when_s + 0.15, lambda: setattr(vehicle, "silent", True))]


@pytest.mark.parametrize("fake", [fake_flight, fake_following])
def test_a_pilot_whom_one_heartbeat_shows_before_the_link_is_lost_keeps_control(
    fake: Callable[..., FakeFlight],
) -> None:
    """Nothing that was heard contradicts it, and the problem names the mode."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    one_heartbeat_then_silence(vehicle, 40.0)
    flight = fake(vehicle)
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("link lost", False)
    assert "last heartbeat showed LOITER, which somebody else chose" in (record.problem or "")
    assert "RTL" not in vehicle.requested
    assert flight.of(events.ReturnCommanded) == []


def test_a_pilot_whom_one_heartbeat_shows_in_the_climb_keeps_control() -> None:
    """Before AUTO it is an error."""
    vehicle = FakeVehicle(FakeClock())
    one_heartbeat_then_silence(vehicle, 10.5)
    with pytest.raises(VehicleError, match="last heartbeat showed LOITER"):
        fake_flight(vehicle).fly()
    assert "RTL" not in vehicle.requested


@pytest.mark.parametrize("mode", ["LOITER", "AUTO"])
def test_ctrl_c_in_a_silence_leaves_the_pilot_in_control_until_a_heartbeat_tells(mode: str) -> None:
    """The one that showed the pilot's mode may have been an old one: then RTL is requested."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    one_heartbeat_then_silence(vehicle, 30.0)

    def interrupt() -> None:
        raise KeyboardInterrupt

    def heard_again() -> None:
        assert "RTL" not in vehicle.requested
        vehicle.mode, vehicle.silent = mode, False

    vehicle.schedule += [(36.0, interrupt), (42.0, heard_again)]
    with pytest.raises(KeyboardInterrupt):
        fake_flight(vehicle).fly()
    assert vehicle.mode == ("LOITER" if mode == "LOITER" else "RTL")
