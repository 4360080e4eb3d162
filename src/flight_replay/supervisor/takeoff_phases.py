"""The phases from the ground to the start of the mission; each function ends when its phase is done.

Each raises ``PhaseTimeoutError`` with the autopilot's own reason at its deadline, and ``FlightEnded``
(see ``flight_ended``) when the vehicle, its pilot or its link ends the flight.
"""

from __future__ import annotations

from contextlib import suppress

from flight_replay.events import Climbing, Phase, PhaseStarted, TargetAltitudeReached, VehicleState, Waiting
from flight_replay.exceptions import PhaseTimeoutError, VehicleError
from flight_replay.mission.items import TAKEOFF_REACHED_SHARE
from flight_replay.supervisor import flight_ended
from flight_replay.supervisor.flight_ended import quoted
from flight_replay.supervisor.motion.height_watch import SUNK_M, Sinking
from flight_replay.supervisor.timers import RETRY_S, Deadline, ProgressTimer, RetryTimer
from flight_replay.supervisor.vehicle_interface import Request
from flight_replay.supervisor.vehicle_monitor import VehicleMonitor

_RETRY_UNACKED_S = 3.0  # Firmware that sends no ack does not tell that a request is lost.
_RETRY_UNACKED_ARM_S = 5.0  # ArduCopter 3.3 arms within 3 to 4 s, and starts over at a second request.
_RETRY_UNACKED_WALL_S = 1.0  # The vehicle's clock may run fast, and the ack be on its way.
_POSITION_WALL_S = 10.0
_PREARM_CHECKS_S = 5.0
_OFF_GROUND_M = 1.0
_MIN_CLIMB_M = 0.5  # A smaller gain of height is no climb.
_LEVEL_M_S, _LEVELLING_S = 0.1, 10.0
_MAX_ARMINGS = 3
_IDLE_S, _IDLE_TOLERANCE_S = 10.0, 1.5
"""ArduCopter disarms by itself so long after arming (the default of DISARM_DELAY), if it has not begun to
take off; heartbeats, once a second, tell when."""


def wait_prearm(monitor: VehicleMonitor) -> None:
    """Wait until the vehicle is ready to arm, and emit its own reasons meanwhile."""
    monitor.emit(PhaseStarted(Phase.PREARM))
    progress, checks = ProgressTimer(monitor), Deadline(monitor, _PREARM_CHECKS_S)
    deadline = Deadline(monitor, monitor.deadlines.prearm_s)
    while not _is_ready(monitor):
        reason = monitor.reason or (monitor.prearm.reason if monitor.prearm else "")
        if deadline.passed:
            raise PhaseTimeoutError(_not_ready(monitor))
        if checks.passed:
            monitor.vehicle.request_prearm_checks()
            checks.restart()
        if progress.due():
            monitor.emit(Waiting(Phase.PREARM, reason))
        monitor.step()


def _not_ready(monitor: VehicleMonitor) -> str:
    """What a person is told if it is not: the vehicle's own reason, or else what is missing."""
    missing = monitor.prearm.reason if monitor.prearm else "it told nothing of it"
    unheard = "no position comes" if monitor.state is None else "no heartbeat comes"
    why = f"{missing or unheard}; check its GPS, compass, stream rates and status texts"
    if monitor.reason:
        why = f'it says "{monitor.reason}"; put that right, then start again'
    return f"the vehicle was not ready to arm in {monitor.deadlines.prearm_s:.0f} s: {why}"


def _is_ready(monitor: VehicleMonitor) -> bool:
    """Whether the vehicle reported that it is disarmed, where it is, and that it is ready to arm."""
    _check_not_armed_by_others(monitor)
    known = monitor.armed is not None and monitor.state is not None
    return known and monitor.prearm is not None and monitor.prearm.ready


def _check_not_armed_by_others(monitor: VehicleMonitor) -> None:
    """Whoever armed the vehicle before this program requested it has control of it."""
    if monitor.armed and not monitor.arm_requested:
        raise VehicleError(
            f"the vehicle is already armed, in mode {monitor.mode}; land and disarm it, then start again"
        )


def change_mode(monitor: VehicleMonitor, mode: str) -> None:
    """Change the flight mode, confirmed by a heartbeat, and expect the vehicle to stay in it.

    A mode is requested again only when the first request was refused or lost, or after a long time:
    a second request on its way would overrule the vehicle or its pilot.
    """
    monitor.catch_up()
    monitor.begin_phase()
    monitor.modes.expect_change(mode)
    deadline, retry = Deadline(monitor, monitor.deadlines.mode_s), RetryTimer(monitor)
    while not monitor.modes.changed:
        _check_not_armed_by_others(monitor)
        if deadline.passed:
            reason = _refusal(monitor, Request.MODE)
            raise PhaseTimeoutError(_timeout(f"did not change to {mode}", monitor.deadlines.mode_s, reason))
        if not monitor.unexpected_mode and retry.due(*_retry_after(monitor, Request.MODE, _RETRY_UNACKED_S)):
            monitor.requests.sending()
            monitor.vehicle.request_mode(mode)
        monitor.step()


def _retry_after(monitor: VehicleMonitor, request: Request, unacked_s: float) -> tuple[float, ...]:
    """When to send a request again: seconds of vehicle time, and of wall-clock time at least."""
    return (RETRY_S,) if monitor.requests.failed(request) else (unacked_s, _RETRY_UNACKED_WALL_S)


def verify_mission(monitor: VehicleMonitor) -> None:
    """Check that the mission on board is still the one that was uploaded."""
    monitor.mission_replaced = False
    if not monitor.vehicle.mission_verified(monitor.catch_up):
        raise VehicleError(
            "the mission on board is not the one that was uploaded: another ground station changed it; "
            "disconnect that station, then start again"
        )


def arm(monitor: VehicleMonitor) -> None:
    """Arm; requested again only after a refusal, or when no arming takes that long.

    Raises:
        VehicleError: Somebody else disarmed it before a heartbeat showed it armed.
    """
    monitor.emit(PhaseStarted(Phase.ARM))
    monitor.catch_up()
    monitor.begin_phase()
    progress, retry = ProgressTimer(monitor), RetryTimer(monitor)
    deadline = Deadline(monitor, monitor.deadlines.arm_s)
    progress.due()  # The start of the phase was emitted just now.
    began_s = monitor.time_s
    while not monitor.armed:
        if monitor.requests.told_of_disarming:
            raise _disarmed_by_others(monitor, monitor.time_s - began_s)
        reason = _refusal(monitor, Request.ARM)
        if deadline.passed:
            raise PhaseTimeoutError(_timeout("did not arm", monitor.deadlines.arm_s, reason))
        retry_after = _retry_after(monitor, Request.ARM, _RETRY_UNACKED_ARM_S)
        if not monitor.unexpected_mode and retry.due(*retry_after) and _confirmed(monitor, deadline):
            monitor.requests.clear()
            monitor.begin_arming()
            monitor.vehicle.request_arm()
        if progress.due():
            monitor.emit(Waiting(Phase.ARM, reason))
        monitor.step()
    _check_not_armed_by_others(monitor)


class _ArmedMeanwhileError(Exception):
    """The vehicle is armed before somebody is asked: an earlier request took long, or it was not ours."""


def _confirmed(monitor: VehicleMonitor, deadline: Deadline) -> bool:
    """Whether arming is still to be requested once it is confirmed; a person who is asked may take long."""
    with suppress(_ArmedMeanwhileError):
        if monitor.confirm_arming(lambda: _next_state(monitor)):
            monitor.catch_up()
            deadline.restart()
    return not monitor.armed and not monitor.unexpected_mode


def _next_state(monitor: VehicleMonitor) -> VehicleState:
    """The vehicle's next position after another heartbeat, which shows whether it is armed by now."""
    monitor.catch_up()
    before_s, end_s = monitor.time_s, monitor.wall_s + _POSITION_WALL_S
    while monitor.state is None or monitor.time_s - before_s < RETRY_S:
        if monitor.wall_s > end_s:
            raise PhaseTimeoutError("the vehicle no longer sends its position; check the link and its GPS")
        monitor.step()
    if monitor.armed:
        raise _ArmedMeanwhileError
    return monitor.state


def arm_and_takeoff(monitor: VehicleMonitor, altitude_m: float) -> None:
    """Arm and take off; again if the vehicle, which the take-off did not reach, disarms itself after 10 s."""
    for _ in range(_MAX_ARMINGS):
        arm(monitor)
        if take_off(monitor, altitude_m):
            return
    raise VehicleError(
        f"the vehicle disarmed {_MAX_ARMINGS} times before take-off{quoted(monitor.reason)}; check the link"
    )


def take_off(monitor: VehicleMonitor, altitude_m: float) -> bool:
    """Climb to 95 % of ``altitude_m`` above home, and level off; False if the vehicle disarmed on the ground.

    Raises:
        VehicleError: Somebody else disarmed it, perhaps standing beside it; or it disarmed in the air.
    """
    monitor.emit(PhaseStarted(Phase.TAKEOFF))
    monitor.begin_phase()
    enough_m, began_s = altitude_m * TAKEOFF_REACHED_SHARE, monitor.time_s
    climb, progress, retry = _Climb(monitor), ProgressTimer(monitor), RetryTimer(monitor)
    deadline = Deadline(monitor, monitor.deadlines.no_climb_s)
    while not climb.reached(enough_m):
        if climb.goes_on():
            deadline.restart()
        if monitor.modes.disarmed_at_s is not None:
            if not climb.on_ground:
                raise _disarmed_in_the_air(monitor, climb.highest_m)
            _check_disarmed_itself(monitor, monitor.modes.disarmed_at_s - began_s)
            return False
        climb.check_not_sunk()
        if deadline.passed:
            reason = _refusal(monitor, Request.TAKEOFF)
            raise PhaseTimeoutError(_timeout(climb.failure, monitor.deadlines.no_climb_s, reason))
        wanted = climb.begun and climb.on_ground and not monitor.requests.accepted(Request.TAKEOFF)
        if wanted and not monitor.unexpected_mode and retry.due(RETRY_S):
            monitor.vehicle.request_takeoff(altitude_m)
        if progress.due():
            monitor.emit(Climbing(monitor.altitude_m, enough_m, altitude_m))
        monitor.step()
    monitor.emit(TargetAltitudeReached(altitude_m))
    _level_off(monitor)
    return True


class _Climb:
    """How high the vehicle has come: from the first position after it is known to be armed.

    Arming sets home where the vehicle is, so that heights told before it are above another home.
    """

    def __init__(self, monitor: VehicleMonitor) -> None:
        self._monitor, self._before = monitor, monitor.state
        self._ground_m = self.highest_m = monitor.altitude_m
        self.begun = False
        """Whether there is a position after arming."""
        self._sinking = Sinking(monitor)

    def goes_on(self) -> bool:
        """Whether the vehicle is higher than before."""
        now_m = self._monitor.altitude_m
        if not self.begun:
            self.begun = self._monitor.state is not self._before
            self._ground_m = self.highest_m = now_m
        higher = now_m > self.highest_m + _MIN_CLIMB_M
        self.highest_m = now_m if higher else self.highest_m
        return higher

    @property
    def on_ground(self) -> bool:
        """Whether it has not left the ground."""
        return self.highest_m < self._ground_m + _OFF_GROUND_M

    def reached(self, enough_m: float) -> bool:
        """Whether it has climbed, and is as high as that above home."""
        now_m = self._monitor.altitude_m
        return self.begun and now_m > self._ground_m + _MIN_CLIMB_M and now_m >= enough_m

    def check_not_sunk(self) -> None:
        """Check that it has not lost what it climbed.

        Raises:
            FlightEnded: It has, as one whose motor fails.
        """
        now_m, highest_m = self._monitor.altitude_m, self.highest_m
        enough_m = max((highest_m - self._ground_m) / 2, SUNK_M)
        if self._sinking.lasts(too_low=highest_m - now_m > enough_m):
            raise flight_ended.sank_in_takeoff(highest_m, now_m, self._monitor.reason)

    @property
    def failure(self) -> str:
        """What a person is told if it does not."""
        return f"did not climb above {self.highest_m:.1f} m" if self.begun else "did not tell its position"


def _level_off(monitor: VehicleMonitor) -> None:
    """Wait for the end of the climb, though not for long.

    Begun in a climb, a mission's first leg takes up to half a second more or less, by the height.
    """
    deadline = Deadline(monitor, _LEVELLING_S)
    while not deadline.passed and _climbs(monitor):
        if monitor.modes.disarmed_at_s is not None:
            raise _disarmed_in_the_air(monitor, monitor.altitude_m)
        monitor.step()


def _climbs(monitor: VehicleMonitor) -> bool:
    return monitor.state is not None and abs(monitor.state.velocity_m_s[2]) > _LEVEL_M_S


def _check_disarmed_itself(monitor: VehicleMonitor, idle_s: float) -> None:
    """A vehicle that accepted the take-off spins its motors up, and does not disarm itself any more."""
    its_own = abs(idle_s - _IDLE_S) <= _IDLE_TOLERANCE_S
    if not its_own or monitor.requests.accepted(Request.TAKEOFF):
        raise _disarmed_by_others(monitor, idle_s)


def _disarmed_by_others(monitor: VehicleMonitor, idle_s: float) -> VehicleError:
    return VehicleError(
        "the vehicle was disarmed before take-off by the pilot or another ground station, "
        f"{max(idle_s, 0.0):.0f} s after arming{quoted(monitor.reason)}; find out why before starting "
        "again; if it was nobody, check DISARM_DELAY"
    )


def _disarmed_in_the_air(monitor: VehicleMonitor, highest_m: float) -> VehicleError:
    return VehicleError(
        f"the vehicle disarmed during take-off, after climbing to {highest_m:.1f} m"
        f"{quoted(monitor.reason)}; find out why before flying again"
    )


def _refusal(monitor: VehicleMonitor, request: Request) -> str:
    """The vehicle's reason against ``request``: its status text, or the result in its ack."""
    ack = monitor.requests.acks.get(request)
    return monitor.reason or (ack.reason if ack else "")


def _timeout(what: str, limit_s: float, reason: str) -> str:
    return f"the vehicle {what} in {limit_s:.0f} s{quoted(reason) or '; check its status texts'}"
