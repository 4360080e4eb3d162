"""From the ground to the start of the mission: each phase a function that ends when the phase is done.

Each raises ``PhaseTimeoutError`` with the autopilot's own reason when its deadline passes, and
``Interrupted`` (see ``watch``) when the vehicle has other plans.
"""

from __future__ import annotations

from flight_replay.errors import PhaseTimeoutError, VehicleError
from flight_replay.events import Climbing, Phase, PhaseStarted, TargetAltitudeReached, Waiting
from flight_replay.mission.items import ENOUGH_OF_TARGET
from flight_replay.supervisor.timers import Deadline, Pace, Repeat
from flight_replay.supervisor.vehicle_interface import Request
from flight_replay.supervisor.vehicle_monitor import Watch

_AGAIN_S = 1.2  # Heartbeats show once a second what came of a request.
_BLIND_S, _ARM_BLIND_S = 3.0, 5.0  # Where nothing tells that a request got lost: ArduCopter 3.3 shows
# arming after 3 to 4 s, and a second request begins them anew.
_BLIND_WALL_S = 1.0  # The vehicle's clock may run fast, and the answer be under way.
_PREARM_REPORT_S = 5.0
_OFF_GROUND_M = 1.0
_GAIN_M = 0.5  # Less height than this is no climb.
_STARTS = 3
_IDLE_S = 4.0  # A vehicle that disarms sooner than this was disarmed: ArduCopter waits for 10 s.


def wait_ready(watch: Watch) -> None:
    """Wait until the vehicle can be armed, showing its own reasons meanwhile."""
    watch.emit(PhaseStarted(Phase.PREARM))
    watch.forget_reason()
    pace, report = Pace(watch), Deadline(watch, _PREARM_REPORT_S)
    deadline = Deadline(watch, watch.deadlines.prearm_s)
    while not _known_ready(watch):
        reason = watch.reason or (watch.readiness.reason if watch.readiness else "")
        if deadline.passed:
            raise PhaseTimeoutError(_late("was not ready to arm", watch.deadlines.prearm_s, reason))
        if report.passed:
            watch.vehicle.ask_prearm_report()
            report.restart()
        if pace.due():
            watch.emit(Waiting(Phase.PREARM, reason))
        watch.step()


def _known_ready(watch: Watch) -> bool:
    """Whether the vehicle is known to be on the ground, disarmed, somewhere, and ready."""
    _check_not_armed_by_others(watch)
    told = watch.armed is not None and watch.state is not None
    return told and watch.readiness is not None and watch.readiness.ready


def _check_not_armed_by_others(watch: Watch) -> None:
    """Whoever armed the vehicle before it was asked for here has control of it."""
    if watch.armed and not watch.arm_asked:
        raise VehicleError(
            f"the vehicle is armed already, in mode {watch.mode}; land and disarm it, then start again"
        )


def change_mode(watch: Watch, mode: str) -> None:
    """Get the vehicle into ``mode``, confirmed by its heartbeat, and expect it to stay there.

    A mode is asked for again only when the first request is known to have been refused or lost, or
    after long: a second one that is under way would overrule what the vehicle or its pilot do.
    """
    watch.catch_up()
    watch.forget_reason()
    watch.modes.expect_change(mode)
    deadline, repeat = Deadline(watch, watch.deadlines.mode_s), Repeat(watch)
    while not watch.modes.changed:
        _check_not_armed_by_others(watch)
        if deadline.passed:
            reason = _refusal(watch, Request.MODE)
            raise PhaseTimeoutError(_late(f"did not change to mode {mode}", watch.deadlines.mode_s, reason))
        if not watch.mode_in_doubt and repeat.due(*_patience_s(watch, Request.MODE, _BLIND_S)):
            watch.requests.asking()
            watch.vehicle.ask_mode(mode)
        watch.step()


def _patience_s(watch: Watch, request: Request, blind_s: float) -> tuple[float, ...]:
    """After how many seconds of the vehicle's time, and at least here, to ask again."""
    return (_AGAIN_S,) if watch.requests.failed(request) else (blind_s, _BLIND_WALL_S)


def verify_mission(watch: Watch) -> None:
    """Make sure that the mission on board is still the one that was uploaded."""
    watch.mission_replaced = False
    if not watch.vehicle.mission_verified(watch.catch_up):
        raise VehicleError(
            "the mission on board is not the one that was uploaded: another station changed it; "
            "disconnect that station, then start again"
        )


def arm(watch: Watch) -> None:
    """Arm, patiently: again only after a refusal, or after a silence longer than any arming takes."""
    watch.emit(PhaseStarted(Phase.ARM))
    watch.catch_up()
    watch.forget_reason()
    pace, repeat = Pace(watch), Repeat(watch)
    deadline = Deadline(watch, watch.deadlines.arm_s)
    pace.due()  # The phase's start was told just now.
    while not watch.armed:
        reason = _refusal(watch, Request.ARM)
        if deadline.passed:
            raise PhaseTimeoutError(_late("did not arm", watch.deadlines.arm_s, reason))
        if not watch.mode_in_doubt and repeat.due(*_patience_s(watch, Request.ARM, _ARM_BLIND_S)):
            watch.requests.forget()
            watch.begin_arming()
            watch.vehicle.ask_arm()
        if pace.due():
            watch.emit(Waiting(Phase.ARM, reason))
        watch.step()
    _check_not_armed_by_others(watch)


def go_up(watch: Watch, altitude_m: float) -> None:
    """Arm and take off; again if the vehicle disarms itself first, as it does after 10 s on the ground."""
    for _ in range(_STARTS - 1):
        arm(watch)
        if take_off(watch, altitude_m):
            return
    arm(watch)
    if not take_off(watch, altitude_m):
        raise VehicleError(f"the vehicle disarmed before it climbed{_because(watch.reason)}; check the link")


def take_off(watch: Watch, altitude_m: float) -> bool:
    """Climb to ``altitude_m`` above home; 95 % of it counts. Whether it did: False if it disarmed itself.

    Raises:
        VehicleError: Somebody else disarmed it: whoever that was may stand beside it. Or it fell.
    """
    watch.emit(PhaseStarted(Phase.TAKEOFF))
    watch.forget_reason()
    enough_m = altitude_m * ENOUGH_OF_TARGET
    ground_m = highest_m = watch.altitude_m
    began_s = watch.time_s
    pace, repeat = Pace(watch), Repeat(watch)
    deadline = Deadline(watch, watch.deadlines.no_climb_s)
    while watch.altitude_m < enough_m:
        if watch.altitude_m > highest_m + _GAIN_M:
            highest_m = watch.altitude_m
            deadline.restart()
        on_ground = highest_m < ground_m + _OFF_GROUND_M
        if watch.modes.disarmed_at_s is not None:
            if not on_ground:
                raise _disarmed_in_the_air(watch, highest_m)
            _check_it_disarmed_itself(watch, watch.modes.disarmed_at_s - began_s)
            return False
        if deadline.passed:
            reason = _refusal(watch, Request.TAKEOFF)
            raise PhaseTimeoutError(_late(f"stayed at {highest_m:.1f} m", watch.deadlines.no_climb_s, reason))
        wanted = on_ground and not watch.requests.accepted(Request.TAKEOFF)
        if wanted and not watch.mode_in_doubt and repeat.due(_AGAIN_S):
            watch.vehicle.ask_takeoff(altitude_m)
        if pace.due():
            watch.emit(Climbing(watch.altitude_m, enough_m, altitude_m))
        watch.step()
    watch.emit(TargetAltitudeReached(altitude_m))
    return True


def _check_it_disarmed_itself(watch: Watch, idle_s: float) -> None:
    if idle_s < _IDLE_S:
        raise VehicleError(
            f"the vehicle was disarmed by somebody else before it climbed{_because(watch.reason)}; "
            "find out why before starting again"
        )


def _disarmed_in_the_air(watch: Watch, highest_m: float) -> VehicleError:
    return VehicleError(
        f"the vehicle disarmed after it had climbed to {highest_m:.1f} m{_because(watch.reason)}; "
        "look after it, and find out why before starting again"
    )


def _refusal(watch: Watch, request: Request) -> str:
    """The vehicle's reason against ``request``: its words, or the code of its answer."""
    answer = watch.requests.answers.get(request)
    return watch.reason or (answer.reason if answer else "")


def _late(what: str, limit_s: float, reason: str) -> str:
    return f"the vehicle {what} within {limit_s:.0f} s{_because(reason) or '; look at its messages'}"


def _because(reason: str) -> str:
    return f': it says "{reason}"' if reason else ""
