"""From the ground to the top of the climb: what is requested when, and how each phase ends."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from flight_replay import events
from flight_replay.events import Phase, VehicleState, Waiting
from flight_replay.exceptions import PhaseTimeoutError, VehicleError
from flight_replay.supervisor import fly
from flight_replay.supervisor.vehicle_interface import (
    Heartbeat,
    PrearmStatus,
    Request,
    RequestAck,
    RequestLost,
)
from tests.helpers.fake_vehicle import FakeClock, FakeVehicle
from tests.helpers.supervised import fake_flight


def test_a_high_take_off_takes_as_long_as_it_climbs() -> None:
    """100 m at 2.5 m/s are 40 s: the 25 s without a climb count from the last gain of height."""
    flight = fake_flight(takeoff_altitude_m=100.0)
    assert flight.fly().problem is None
    assert flight.of(events.TargetAltitudeReached) == [events.TargetAltitudeReached(100.0)]


def test_a_take_off_is_over_at_95_percent_of_its_altitude() -> None:
    """The vehicle need not climb any farther."""
    vehicle = FakeVehicle(FakeClock())

    def climb_to_19_m(altitude_m: float) -> None:
        vehicle.requested.append("takeoff")
        vehicle.target_m = 19.0

    vehicle.request_takeoff = climb_to_19_m  # type: ignore[method-assign]
    assert fake_flight(vehicle, takeoff_altitude_m=20.0).fly().problem is None


def test_the_mission_begins_when_the_climb_is_over() -> None:
    """The first leg of a mission that is begun in a climb takes longer or shorter by up to half a second."""
    flight = fake_flight(takeoff_altitude_m=30.0)
    begun_m: list[float] = []
    request_mode = flight.vehicle.request_mode

    def note(mode: str) -> None:
        if mode == "AUTO":
            begun_m.append(flight.vehicle.altitude_m)
        request_mode(mode)

    flight.vehicle.request_mode = note  # type: ignore[method-assign]
    assert flight.fly().problem is None
    assert begun_m[0] == 30.0


def test_a_vehicle_that_is_never_level_begins_after_ten_seconds() -> None:
    """A vertical speed that is only noise does not hold the flight up."""
    vehicle = FakeVehicle(FakeClock())
    move = vehicle.move

    def bob(step_s: float) -> None:
        move(step_s)
        vehicle.velocity_m_s[2] = 0.5

    vehicle.move = bob  # type: ignore[method-assign]
    flight, calm = fake_flight(vehicle), fake_flight()
    assert flight.fly().problem is None
    assert calm.fly().problem is None
    assert 8.0 < flight.wall_s - calm.wall_s < 11.0


def test_a_vehicle_that_disarms_while_it_levels_off_is_an_error() -> None:
    """It is falling, or was on the ground all the time."""
    vehicle = FakeVehicle(FakeClock())

    def climb_for_long(altitude_m: float) -> None:
        vehicle.requested.append("takeoff")
        vehicle.target_m = altitude_m + 100.0

    def disarm() -> None:
        vehicle.armed = False

    vehicle.request_takeoff = climb_for_long  # type: ignore[method-assign]
    vehicle.schedule.append((19.0, disarm))
    with pytest.raises(VehicleError, match=r"the vehicle disarmed during take-off, after climbing to \d+"):
        fake_flight(vehicle).fly()


def test_a_climb_that_stops_halfway_ends_in_rtl() -> None:
    """The height that was reached is in the message, 25 s later."""
    flight = fake_flight()
    stopped: list[float] = []

    def stop() -> None:
        flight.vehicle.climbs = False
        stopped.append(flight.vehicle.altitude_m)

    flight.vehicle.schedule.append((12.0, stop))
    with pytest.raises(
        PhaseTimeoutError, match=r"the vehicle did not climb above (\d+\.\d) m in 25 s"
    ) as error:
        flight.fly()
    assert f"{stopped[0]:.1f} m" in str(error.value) or f"{stopped[0] - 0.25:.1f} m" in str(error.value)
    assert flight.of(events.ReturnCommanded) == [events.ReturnCommanded(True)]
    assert 12 + 25 < flight.wall_s < 12 + 25 + 3


def test_take_off_is_requested_again_until_the_vehicle_climbs() -> None:
    """The fake vehicle sends no ack: while it stays on the ground, every 1.2 s."""
    flight = fake_flight(FakeVehicle(FakeClock(), climbs=False))
    flight.vehicle.schedule.append((10.0, lambda: setattr(flight.vehicle, "climbs", True)))
    assert flight.fly().problem is None
    requests = flight.vehicle.requested.count("takeoff")
    assert 4 <= requests <= 6


def test_an_accepted_take_off_is_not_requested_again() -> None:
    """ArduCopter may spool up for seconds before it climbs."""
    vehicle = FakeVehicle(FakeClock(), climbs=False)
    vehicle.schedule.append((10.0, lambda: setattr(vehicle, "climbs", True)))
    request_takeoff = vehicle.request_takeoff

    def accept(altitude_m: float) -> None:
        request_takeoff(altitude_m)
        vehicle.queue.append(RequestAck(Request.TAKEOFF, True))

    vehicle.request_takeoff = accept  # type: ignore[method-assign]
    assert fake_flight(vehicle).fly().problem is None
    assert vehicle.requested.count("takeoff") == 1


def test_a_refused_take_off_gives_its_reason() -> None:
    """The result in the ack, where no status text explains it."""
    vehicle = FakeVehicle(FakeClock(), climbs=False)
    request_takeoff = vehicle.request_takeoff

    def refuse(altitude_m: float) -> None:
        request_takeoff(altitude_m)
        vehicle.queue.append(RequestAck(Request.TAKEOFF, False, "temporarily rejected"))

    vehicle.request_takeoff = refuse  # type: ignore[method-assign]
    with pytest.raises(PhaseTimeoutError, match=r'in 25 s: it says "temporarily rejected"$'):
        fake_flight(vehicle).fly()
    assert vehicle.requested.count("takeoff") > 10


def test_a_gain_of_less_than_half_a_metre_is_not_a_climb() -> None:
    """The wait for a climb goes on."""
    vehicle = FakeVehicle(FakeClock(), climbs=False)

    def lift() -> None:
        vehicle.altitude_m = 0.4

    vehicle.schedule.append((8.0, lift))
    with pytest.raises(
        PhaseTimeoutError, match=r"did not climb above 0\.0 m in 25 s; check its status texts$"
    ):
        fake_flight(vehicle).fly()


@pytest.mark.parametrize("text", ["Potential Thrust Loss (1)", ""])
def test_a_vehicle_that_loses_what_it_climbed_is_told_soon(text: str) -> None:
    """A motor that failed: it does not climb any more, and 25 s at full throttle on the ground are long."""
    flight = fake_flight()
    vehicle = flight.vehicle

    def fall() -> None:
        vehicle.climbs, vehicle.altitude_m = False, 1.0
        if text:
            vehicle.send_text(text, 0)

    vehicle.schedule.append((12.0, fall))
    said = r': it says "Potential Thrust Loss \(1\)"' if text else ""
    with pytest.raises(
        VehicleError, match=rf"sank from \d+\.\d m to 1\.0 m during take-off{said}; keep away"
    ):
        flight.fly()
    assert flight.of(events.ReturnCommanded) == [events.ReturnCommanded(True)]
    assert flight.wall_s < 12 + 15


@pytest.mark.parametrize(
    ("altitude_m", "problem"),
    [(0.99, "was disarmed before take-off by"), (1.0, "disarmed during take-off, after climbing to 1.0 m")],
)
def test_a_vehicle_that_gained_a_metre_is_in_the_air(altitude_m: float, problem: str) -> None:
    """Disarming there is never taken for its own on the ground."""
    vehicle = FakeVehicle(FakeClock(), climbs=False)

    def lift() -> None:
        vehicle.altitude_m = altitude_m

    def disarm() -> None:
        vehicle.armed = False

    vehicle.schedule += [(6.0, lift), (7.0, disarm)]
    with pytest.raises(VehicleError, match=problem):
        fake_flight(vehicle).fly()


def test_a_refused_arming_is_requested_again_soon() -> None:
    """1.2 s after each refusal; it succeeds when the refusals end."""
    vehicle = FakeVehicle(FakeClock(), refuse_arm="Arm: Throttle too high")
    vehicle.schedule.append((10.0, lambda: setattr(vehicle, "refuse_arm", "")))
    flight = fake_flight(vehicle)
    assert flight.fly().problem is None
    assert 5 <= vehicle.requested.count("arm") <= 7
    reasons = [event.reason for event in flight.of(Waiting) if event.phase is Phase.ARM]
    assert "Arm: Throttle too high" in reasons
    assert 5 <= len(reasons) <= 8, "one a second"


def test_each_arming_is_confirmed_just_before_it_is_requested() -> None:
    """With where the vehicle is; a person who is asked may take minutes, which do not count."""
    vehicle = FakeVehicle(FakeClock(), ready_after_s=20.0, refuse_arm="Arm: Throttle too high")
    vehicle.schedule.append((150.0, lambda: setattr(vehicle, "refuse_arm", "")))
    asked: list[VehicleState] = []

    def ask(next_state: Callable[[], VehicleState]) -> bool:
        vehicle.requested.append("ask")
        if vehicle.requested.count("ask") % 5 != 1:
            return False
        asked.append(next_state())
        vehicle.clock.now_s += 70.0
        return True

    flight = fake_flight(vehicle)
    assert fly(vehicle, vehicle.clock, flight.plan, flight.events.append, ask).problem is None
    until_armed = vehicle.requested[: vehicle.requested.index("takeoff")]
    assert [what for what in until_armed if what in ("ask", "arm")][:4] == ["ask", "arm", "ask", "arm"]
    assert until_armed.count("ask") == until_armed.count("arm") > 5
    assert vehicle.requested.index("GUIDED") < vehicle.requested.index("ask")
    assert asked[0].time_s > 70.0
    assert not [event for event in flight.events if isinstance(event, events.LinkLost)]


@pytest.mark.parametrize("what", ["mode", "armed", "silent"])
def test_what_changes_while_a_person_is_asked_keeps_it_from_being_armed(what: str) -> None:
    """Another mode, somebody else who arms it, or a link that is gone, which the position after it shows."""
    vehicle = FakeVehicle(FakeClock())

    def ask(next_state: Callable[[], VehicleState]) -> bool:
        vehicle.clock.now_s += 70.0
        vehicle.mode = "LOITER" if what == "mode" else vehicle.mode
        vehicle.armed, vehicle.silent = what == "armed", what == "silent"
        if what == "silent":
            next_state()
        return True

    with pytest.raises(VehicleError):
        fly(vehicle, vehicle.clock, fake_flight(vehicle).plan, confirm_arming=ask)
    assert "arm" not in vehicle.requested
    assert "RTL" not in vehicle.requested


def test_nobody_is_asked_about_a_vehicle_that_is_armed_by_now() -> None:
    """An earlier request of ours took long: it takes off."""
    vehicle = FakeVehicle(FakeClock(), refuse_arm="Arm: Throttle too high")

    def ask(next_state: Callable[[], VehicleState]) -> bool:
        vehicle.requested.append("ask")
        if vehicle.requested.count("ask") > 1:
            vehicle.armed = True
            next_state()
            raise AssertionError
        return True

    assert fly(vehicle, vehicle.clock, fake_flight(vehicle).plan, confirm_arming=ask).problem is None
    assert vehicle.requested.count("arm") == 1


def test_without_a_position_nobody_is_asked() -> None:
    """Where the vehicle is has to be shown; what is not confirmed is not armed."""
    vehicle = FakeVehicle(FakeClock())

    def ask(next_state: Callable[[], VehicleState]) -> bool:
        vehicle.reports_clock = False
        next_state()
        raise AssertionError

    with pytest.raises(PhaseTimeoutError, match="no longer sends its position"):
        fly(vehicle, vehicle.clock, fake_flight(vehicle).plan, confirm_arming=ask)
    assert "arm" not in vehicle.requested


def test_an_arming_without_an_ack_is_requested_again_after_five_seconds() -> None:
    """A lost packet, or a firmware that sends no ack."""
    vehicle = FakeVehicle(FakeClock())
    request_arm = vehicle.request_arm
    times_s: list[float] = []

    def lose_the_first() -> None:
        times_s.append(vehicle.time_s)
        if len(times_s) > 1:
            request_arm()

    vehicle.request_arm = lose_the_first  # type: ignore[method-assign]
    assert fake_flight(vehicle).fly().problem is None
    assert len(times_s) == 2
    assert times_s[1] - times_s[0] == pytest.approx(5.0, abs=0.3)


def test_a_vehicle_that_somebody_disarms_before_it_is_seen_armed_is_not_armed_again() -> None:
    """He may stand beside it."""
    vehicle = FakeVehicle(FakeClock())

    def disarmed_at_once() -> None:
        vehicle.queue.append(RequestAck(Request.ARM, True))
        vehicle.schedule.append((vehicle.time_s + 0.5, lambda: vehicle.send_text("Disarming motors", 6)))

    vehicle.request_arm = disarmed_at_once  # type: ignore[method-assign]
    with pytest.raises(VehicleError, match="disarmed before take-off by the pilot or another ground station"):
        fake_flight(vehicle).fly()
    assert "takeoff" not in vehicle.requested


def test_pre_arm_checks_are_requested_every_five_seconds() -> None:
    """While the vehicle is not ready, and the first time after 5 s; its own text is emitted as the reason."""
    vehicle = FakeVehicle(FakeClock(), ready_after_s=17.0)
    vehicle.schedule.append((7.0, lambda: vehicle.send_text("PreArm: Compass not calibrated")))
    flight = fake_flight(vehicle)
    assert flight.fly().problem is None
    assert vehicle.requested.count("report") == 3
    waits = [event.reason for event in flight.of(Waiting) if event.phase is Phase.PREARM]
    assert waits[0] == ""
    assert waits[3] == "no position yet"
    assert waits[-1] == "PreArm: Compass not calibrated"
    assert len(waits) == pytest.approx(17, abs=2)


def test_all_checks_of_the_last_run_that_failed_are_the_reason() -> None:
    """The last text alone may be a consequence of the first."""
    vehicle = FakeVehicle(FakeClock(), ready_after_s=999.0)
    runs = ((7.0, "EKF attitude is bad"), (7.0, "RC not found"), (100.0, "EKF attitude is bad"))
    for when_s, text in (*runs, (100.2, "Compass not healthy")):
        vehicle.schedule.append((when_s, lambda text=text: vehicle.send_text(f"PreArm: {text}")))  # type: ignore[misc]
    said = 'it says "PreArm: EKF attitude is bad; PreArm: Compass not healthy"; put that right'
    with pytest.raises(PhaseTimeoutError, match=said):
        fake_flight(vehicle).fly()


def test_what_the_vehicle_lacks_is_told_where_it_gives_no_reason() -> None:
    with pytest.raises(PhaseTimeoutError, match="in 180 s: no position yet; check its GPS, compass"):
        fake_flight(FakeVehicle(FakeClock(), ready_after_s=999.0)).fly()


@pytest.mark.parametrize(
    ("missing", "told"),
    [
        (Heartbeat, "no heartbeat comes; check"),
        (VehicleState, "no position comes; check"),
        (PrearmStatus, "it told nothing of it; check"),
    ],
)
def test_a_report_that_never_comes_is_named(missing: type, told: str) -> None:
    """Where nothing else keeps the vehicle from being ready."""
    vehicle = FakeVehicle(FakeClock(), ready_after_s=0.0)
    report = vehicle.report

    def left_out() -> None:
        report()
        vehicle.queue = [item for item in vehicle.queue if not isinstance(item, missing)]

    vehicle.report = left_out  # type: ignore[method-assign]
    with pytest.raises(PhaseTimeoutError, match=told):
        fake_flight(vehicle).fly()


@pytest.mark.parametrize("missing", [Heartbeat, VehicleState, PrearmStatus])
def test_a_vehicle_is_ready_only_with_all_reports(missing: type) -> None:
    """Heartbeat, position and pre-arm status: while one of them is missing, nothing is requested."""
    vehicle = FakeVehicle(FakeClock(), ready_after_s=0.0)
    report = vehicle.report
    requested: list[list[str]] = []

    def left_out() -> None:
        report()
        if vehicle.time_s < 60.0:
            vehicle.queue = [item for item in vehicle.queue if not isinstance(item, missing)]

    vehicle.report = left_out  # type: ignore[method-assign]
    vehicle.schedule.append((9.9, lambda: requested.append(list(vehicle.requested))))
    assert fake_flight(vehicle).fly().problem is None
    assert "GUIDED" not in requested[0]


def test_a_refused_mode_is_requested_again_until_its_deadline() -> None:
    """Every 1.2 s after a refusal, for 15 s."""
    flight = fake_flight(FakeVehicle(FakeClock(), refuse_mode=frozenset({"GUIDED"})))
    with pytest.raises(PhaseTimeoutError, match=r'did not change to GUIDED in 15 s: it says "FAILED"$'):
        flight.fly()
    assert 11 <= flight.vehicle.requested.count("GUIDED") <= 14


@pytest.mark.parametrize(("idle_s", "again"), [(3.0, False), (6.0, False), (10.0, True), (13.0, False)])
def test_the_time_shows_who_disarmed_the_vehicle(idle_s: float, again: bool) -> None:
    """10 s after arming it disarmed itself, and is armed again; at any other time somebody disarmed it."""
    vehicle = FakeVehicle(FakeClock(), climbs=False)
    request_takeoff = vehicle.request_takeoff

    def disarm_later(altitude_m: float) -> None:
        if "takeoff" not in vehicle.requested:
            vehicle.schedule.append((vehicle.clock.now_s - vehicle.began_s + idle_s, disarm))
        request_takeoff(altitude_m)

    def disarm() -> None:
        vehicle.armed, vehicle.climbs = False, True

    vehicle.request_takeoff = disarm_later  # type: ignore[method-assign]
    flight = fake_flight(vehicle)
    if not again:
        with pytest.raises(
            VehicleError,
            match=r"disarmed before take-off by the pilot or another ground station, \d+ s after arming",
        ):
            flight.fly()
        assert vehicle.requested.count("arm") == 1
        return
    assert flight.fly().problem is None
    assert vehicle.requested.count("arm") == 2


def test_nothing_is_requested_while_the_mode_is_in_doubt() -> None:
    """One heartbeat of a pilot's mode on the ground: the next one shows whose choice it is."""
    vehicle = FakeVehicle(FakeClock(), climbs=False)

    def change() -> None:
        vehicle.mode = "LOITER"
        vehicle.queue.append(Heartbeat("LOITER", True))
        vehicle.heartbeat_s = vehicle.time_s + 3.0
        vehicle.requested.clear()

    vehicle.schedule.append((9.0, change))
    with pytest.raises(VehicleError, match="LOITER by the pilot"):
        fake_flight(vehicle).fly()
    assert vehicle.requested == []


def test_an_armed_vehicle_that_is_never_ready_is_an_error_at_once() -> None:
    """The pre-arm checks of an armed vehicle are not waited for."""
    flight = fake_flight(FakeVehicle(FakeClock(), ready_after_s=1e9))
    flight.vehicle.armed = True
    with pytest.raises(VehicleError, match="already armed, in mode STABILIZE"):
        flight.fly()
    assert flight.wall_s < 3


def test_arming_that_takes_less_than_a_second_emits_no_wait() -> None:
    """The start of the phase is enough."""
    flight = fake_flight(FakeVehicle(FakeClock(), arm_delay_s=0.2))
    flight.fly()
    assert [event for event in flight.of(Waiting) if event.phase is Phase.ARM] == []


@pytest.mark.parametrize(("height_m", "again"), [(0.9, True), (1.2, False)])
def test_take_off_is_requested_again_below_one_metre_only(height_m: float, again: bool) -> None:
    """A vehicle that has left the ground is climbing, or has another problem."""
    vehicle = FakeVehicle(FakeClock(), climbs=False)
    vehicle.schedule += [
        (8.0, lambda: setattr(vehicle, "altitude_m", height_m)),
        (9.0, vehicle.requested.clear),
    ]
    with pytest.raises(PhaseTimeoutError, match=rf"did not climb above {height_m} m"):
        fake_flight(vehicle).fly()
    assert ("takeoff" in vehicle.requested) is again


@pytest.mark.parametrize("speedup", [2.0, 20.0])
def test_an_unacked_request_waits_a_second_of_wall_clock_time(speedup: float) -> None:
    """However fast the vehicle's clock runs, the ack may be on its way."""
    vehicle = FakeVehicle(FakeClock(), speedup=speedup)
    times_s: list[float] = []
    request_mode = vehicle.request_mode

    def lose_the_first(mode: str) -> None:
        if mode == "GUIDED":
            times_s.append(vehicle.clock.now_s)
        if mode != "GUIDED" or len(times_s) > 1:
            request_mode(mode)

    vehicle.request_mode = lose_the_first  # type: ignore[method-assign]
    assert fake_flight(vehicle).fly().problem is None
    assert times_s[1] - times_s[0] == pytest.approx(max(3.0 / speedup, 1.0), abs=0.15)


def test_a_status_text_of_an_earlier_phase_is_not_the_reason() -> None:
    """GUIDED is refused with a result alone, after a text about the compass."""
    vehicle = FakeVehicle(FakeClock(), refuse_mode=frozenset({"GUIDED"}))
    vehicle.schedule.append((1.0, lambda: vehicle.send_text("PreArm: Compass not calibrated")))
    with pytest.raises(PhaseTimeoutError, match='it says "FAILED"'):
        fake_flight(vehicle).fly()


@pytest.mark.parametrize(
    ("refused", "message"),
    [("arm", 'the vehicle did not arm in 60 s: it says "FAILED"'), ("climb", "check its status texts")],
)
def test_a_status_text_from_before_arming_is_not_the_reason(refused: str, message: str) -> None:
    """Neither of arming nor of the take-off."""
    vehicle = FakeVehicle(FakeClock(), climbs=False)

    def verified(while_waiting: Callable[[], None]) -> bool:
        vehicle.send_text("EKF variance")
        while_waiting()
        return True

    def refuse() -> None:
        vehicle.queue.append(RequestAck(Request.ARM, False, "FAILED"))

    def arm() -> None:
        vehicle.send_text("EKF variance")
        vehicle.armed = True

    vehicle.mission_verified = verified  # type: ignore[method-assign]
    vehicle.request_arm = refuse if refused == "arm" else arm  # type: ignore[method-assign]
    with pytest.raises(PhaseTimeoutError, match=message):
        fake_flight(vehicle).fly()


def test_a_vehicle_that_accepted_the_take_off_is_not_armed_again() -> None:
    """Its motors spin up then, and it does not disarm itself: after 10 s, too, somebody disarmed it."""
    vehicle = FakeVehicle(FakeClock(), climbs=False)

    def accept(altitude_m: float) -> None:
        vehicle.requested.append("takeoff")
        vehicle.queue.append(RequestAck(Request.TAKEOFF, True))
        when_s = vehicle.clock.now_s - vehicle.began_s + 10.0
        vehicle.schedule.append((when_s, lambda: setattr(vehicle, "armed", False)))

    vehicle.request_takeoff = accept  # type: ignore[method-assign]
    with pytest.raises(VehicleError, match="disarmed before take-off by the pilot"):
        fake_flight(vehicle).fly()
    assert vehicle.requested.count("arm") == vehicle.requested.count("takeoff") == 1


@pytest.mark.parametrize("request_name", ["arm", "AUTO"])
def test_reports_that_wait_are_processed_before_a_request(request_name: str) -> None:
    """A heartbeat of a pilot's mode that came during the verification: the next one is waited for."""
    vehicle = FakeVehicle(FakeClock())
    verified_s: list[float] = []
    requested_s: dict[str, float] = {}
    request_arm, request_mode = vehicle.request_arm, vehicle.request_mode

    def verified(while_waiting: Callable[[], None]) -> bool:
        while_waiting()
        verified_s.append(vehicle.clock.now_s)
        if len(verified_s) == (1 if request_name == "arm" else 2):
            vehicle.queue.append(Heartbeat("LOITER", vehicle.armed))
        return True

    def arm() -> None:
        requested_s.setdefault("arm", vehicle.clock.now_s)
        request_arm()

    def change_mode(mode: str) -> None:
        requested_s.setdefault(mode, vehicle.clock.now_s)
        request_mode(mode)

    vehicle.mission_verified = verified  # type: ignore[method-assign]
    vehicle.request_arm, vehicle.request_mode = arm, change_mode  # type: ignore[method-assign]
    assert fake_flight(vehicle).fly().problem is None
    assert requested_s[request_name] > verified_s[0 if request_name == "arm" else 1]


def test_a_request_after_a_lost_one_waits_for_its_own_ack() -> None:
    """That the first request for GUIDED is known to be lost says nothing about the second."""
    vehicle = FakeVehicle(FakeClock())
    times_s: list[float] = []
    request_mode = vehicle.request_mode

    def lose_two(mode: str) -> None:
        if mode == "GUIDED":
            times_s.append(vehicle.time_s)
            if len(times_s) == 1:
                vehicle.queue.append(RequestLost(Request.MODE))
        if mode != "GUIDED" or len(times_s) > 2:
            request_mode(mode)

    vehicle.request_mode = lose_two  # type: ignore[method-assign]
    assert fake_flight(vehicle).fly().problem is None
    assert times_s[1] - times_s[0] == pytest.approx(1.2, abs=0.3)
    assert times_s[2] - times_s[1] == pytest.approx(3.0, abs=0.3)


def test_ctrl_c_while_a_second_arming_is_under_way_commands_rtl() -> None:
    """The first one was refused, the second may yet succeed."""
    vehicle = FakeVehicle(FakeClock())
    requests: list[float] = []

    def interrupt() -> None:
        raise KeyboardInterrupt

    def arm() -> None:
        requests.append(vehicle.time_s)
        if len(requests) == 1:
            vehicle.queue.append(RequestAck(Request.ARM, False, "FAILED"))
        else:
            vehicle.arms_at_s = vehicle.time_s + 3.0
            vehicle.schedule.append((vehicle.clock.now_s - vehicle.began_s + 1.0, interrupt))

    vehicle.request_arm = arm  # type: ignore[method-assign]
    with pytest.raises(KeyboardInterrupt):
        fake_flight(vehicle).fly()
    assert vehicle.mode == "RTL"


def test_a_mission_that_another_station_changed_is_an_error() -> None:
    """Before arming."""
    message = (
        "^the mission on board is not the one that was uploaded: another ground station changed it; "
        "disconnect that station, then start again$"
    )
    with pytest.raises(VehicleError, match=message):
        fake_flight(FakeVehicle(FakeClock(), verified=False)).fly()


@pytest.mark.parametrize("before_m", [40.0, 29.0, -3.0])
def test_heights_above_the_home_before_arming_do_not_count(before_m: float) -> None:
    """Arming sets home: the last height before it is neither the ground's nor that of a climb."""
    vehicle = FakeVehicle(FakeClock(), altitude_before_arming_m=before_m)
    request_takeoff = vehicle.request_takeoff

    def lose_the_first(altitude_m: float) -> None:
        if "takeoff" in vehicle.requested:
            request_takeoff(altitude_m)
        vehicle.requested.append("takeoff")

    vehicle.request_takeoff = lose_the_first  # type: ignore[method-assign]
    flight = fake_flight(vehicle)
    assert flight.fly().problem is None
    assert vehicle.requested.count("takeoff") == 3
    climbing_m = [event.altitude_m for event in flight.of(events.Climbing)]
    assert climbing_m[-1] > 25.0


def test_nothing_is_reached_on_ground_that_is_higher_than_the_take_off() -> None:
    """Home is locked 40 m below, and the vehicle refuses the take-off: AUTO would begin on the ground."""
    vehicle = FakeVehicle(FakeClock(), climbs=False)
    vehicle.altitude_m = 40.0
    with pytest.raises(PhaseTimeoutError, match=r"did not climb above 40\.0 m"):
        fake_flight(vehicle).fly()
    assert "AUTO" not in vehicle.requested


def test_take_off_waits_for_a_position_after_arming() -> None:
    """Without one nothing is requested but RTL, when its time is over."""
    vehicle = FakeVehicle(FakeClock())
    request_arm = vehicle.request_arm

    def arm() -> None:
        request_arm()
        vehicle.reports_clock = False

    vehicle.request_arm = arm  # type: ignore[method-assign]
    with pytest.raises(PhaseTimeoutError, match="the vehicle did not tell its position in 25 s"):
        fake_flight(vehicle).fly()
    assert "takeoff" not in vehicle.requested
    assert vehicle.requested[-1] == "RTL"
