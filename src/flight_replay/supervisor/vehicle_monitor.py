"""Turns the reports of a vehicle into what is known of it now, and ends the flight when it has to end.

Two clocks: the vehicle's own times the flight (a simulator's may run 20 times faster), wall-clock time
detects a lost link. Reports are processed one by one, so that conclusions follow from their order and
not from when this program happened to run; no request is sent before all of them are processed.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import singledispatchmethod

from flight_replay.events import Listener, Notice, Severity, StatusText, VehicleState, WaypointReached
from flight_replay.exceptions import LinkFaultError
from flight_replay.geometry.geodesy import ground_distance_m
from flight_replay.mission.items import Mission
from flight_replay.supervisor import flight_ended
from flight_replay.supervisor.flight_plan import Deadlines
from flight_replay.supervisor.link_monitor import LinkMonitor
from flight_replay.supervisor.mission_progress import MissionProgress
from flight_replay.supervisor.mode_monitor import ModeMonitor
from flight_replay.supervisor.motion.home_moves import HomeMoves
from flight_replay.supervisor.motion.position_jumps import PositionJumps
from flight_replay.supervisor.request_tracker import RequestTracker
from flight_replay.supervisor.vehicle_interface import (
    Clock,
    Heartbeat,
    HomePosition,
    MissionCurrent,
    MissionItemReached,
    PrearmStatus,
    Rebooted,
    Report,
    Request,
    RequestAck,
    RequestLost,
    Vehicle,
)

_STEP_WALL_S = 0.1  # The longest wait for a report in one step.
_LINK_GAP_WALL_S = 1.0  # Between two positions farther apart than this, the link was not up.
_CLOCK_JUMP_S = 300.0  # A fast simulator's clock runs on so far while this program is stopped.
_FAILSAFE_TEXTS = ("failsafe", "breach", "crash")
_PREARM_TEXT = "PreArm:"
_CHECK_TEXTS = (_PREARM_TEXT, "Arm:")
_CHECKS_WALL_S = 1.0  # The texts of checks that fail in one run follow each other more closely.
_DISARMING_TEXT = "disarming motors"
_NEW_MISSION_TEXT = "flight plan received"  # From ArduCopter 3.3 on, when a mission was uploaded.
_NO_POSITION_HEARTBEATS = 10  # One a second of the vehicle's time, which has no other clock then.
_NO_POSITION_WALL_S = 5.0  # A fast simulator sends ten in no time, and a link asks for positions anew.
_DOUBT_S = 2.0  # An unexpected mode that no heartbeat repeats for so long does not hold RTL back.
_REASON_VALID_S = 10.0  # An older status text (vehicle time) does not explain a new mode.

ConfirmArming = Callable[[Callable[[], VehicleState]], bool]
"""Called before each request to arm, with what reads the vehicle's position: whether a person was asked.

It raises an error where the vehicle must not be armed.
"""


class _FailedChecks:
    """The status texts of checks before arming that failed in one run: the last may follow from the first."""

    def __init__(self) -> None:
        self._texts: list[str] = []
        self._wall_s = 0.0

    def clear(self) -> None:
        """Forget them."""
        self._texts = []

    def with_others(self, text: str, wall_s: float) -> str:
        """A text that comes now, after those of other checks in the same run if it is of one."""
        if not text.startswith(_CHECK_TEXTS):
            return text
        if wall_s - self._wall_s > _CHECKS_WALL_S or text in self._texts:
            self._texts = []
        self._texts.append(text)
        self._wall_s = wall_s
        return "; ".join(self._texts)


class VehicleMonitor:
    """What is known of the vehicle, and when it was reported."""

    def __init__(self, vehicle: Vehicle, clock: Clock, listener: Listener, deadlines: Deadlines) -> None:
        self.vehicle = vehicle
        self.emit = listener
        self.confirm_arming: ConfirmArming = lambda _: False
        self.deadlines = deadlines
        self._clock = clock
        self._link = LinkMonitor(clock, deadlines)
        self._backlog: deque[Report] = deque()
        self._state_wall_s = 0.0
        self.modes = ModeMonitor()
        self.armed: bool | None = None
        self.state: VehicleState | None = None
        self._jumps, self._home_moves = PositionJumps(), HomeMoves()
        self._before_auto: VehicleState | None = None  # When it was last heard in another mode.
        self._held: list[MissionCurrent | MissionItemReached] = []
        self._heartbeats_since_state = 0
        self.armed_state: VehicleState | None = None
        """The state before the latest heartbeat that showed the vehicle armed."""
        self.prearm: PrearmStatus | None = None
        self.mission = MissionCurrent(0)
        self.mission_replaced = False
        """Whether a mission was uploaded since the one on board was last verified."""
        self.progress, self._jumps_told = MissionProgress(), 0
        self.flown: list[VehicleState] = []
        self._home: VehicleState | None = None
        self.link_up_s = 0.0
        """Seconds of vehicle time that passed while the link was up: the time that deadlines count."""
        self._unexpected_s = self._clock_jump_s = 0.0
        self.auto_start_s: float | None = None
        self._recording = False
        self.requests = RequestTracker()
        self.arm_requested = self.was_armed = False
        self.rtl_confirmed = False
        """Whether the vehicle has confirmed an RTL that was commanded: any mode since is somebody else's."""
        self.told_to_land = False
        """Whether LAND was commanded of a vehicle that fell: RTL would start its motors again."""
        self.taken_over = False
        """Whether somebody else has the vehicle, or had it when last heard: nothing more is commanded."""
        self.reason, self._failed_checks = "", _FailedChecks()
        self._failsafe_text, self._failsafe_s = "", 0.0

    @property
    def mode(self) -> str | None:
        """The flight mode of the latest heartbeat."""
        return self.modes.mode

    @property
    def wall_s(self) -> float:
        """Seconds of wall-clock time."""
        return self._clock.monotonic_s()

    @property
    def time_s(self) -> float:
        """Seconds of vehicle time, 0 before the first position."""
        return self.state.time_s if self.state else 0.0

    @property
    def altitude_m(self) -> float:
        """Metres above home, 0 before the first position."""
        return self.state.alt_m if self.state else 0.0

    @property
    def from_home_m(self) -> float:
        """Metres over the ground from where arming was requested, 0 before that."""
        here, home = self.state, self._home
        return 0.0 if here is None or home is None else ground_distance_m(here, home)

    @property
    def home_moved_m(self) -> float:
        """Metres over the ground from there to where somebody moved home in flight, 0 if nobody did."""
        return self._home_moves.moved_m

    @property
    def failsafe_text(self) -> str:
        """The status text of a failsafe in the last seconds, or empty."""
        return self._failsafe_text if self.time_s - self._failsafe_s <= _REASON_VALID_S else ""

    @property
    def position_jump(self) -> str:
        """The position estimate's jump of the last seconds, as the beginning of a sentence; empty without."""
        return self._jumps.latest(self.time_s)

    @property
    def silence(self) -> str:
        """How long no data has come, as a phrase; empty while the link is up."""
        return self._link.silence

    @property
    def may_be_armed(self) -> bool:
        """Whether the vehicle is armed at our request, or may be soon: ArduCopter takes 3 s to show it."""
        if not self.arm_requested or self.was_armed:
            return self.arm_requested and bool(self.armed)
        ack = self.requests.acks.get(Request.ARM)
        return ack is None or ack.accepted

    @property
    def certainly_disarmed(self) -> bool:
        """Whether the vehicle is disarmed, and did not just reboot."""
        return self.modes.certainly_disarmed(self.wall_s)

    @property
    def unexpected_mode(self) -> bool:
        """Whether the latest heartbeat shows a mode that is not expected."""
        return self.modes.unexpected.count > 0

    @property
    def mode_in_doubt(self) -> bool:
        """Whether that was just now, and the next heartbeat may confirm it.

        Time without data does not count: nothing was heard that would contradict it.
        """
        return self.unexpected_mode and self.link_up_s - self._unexpected_s < _DOUBT_S

    @property
    def caught_up(self) -> bool:
        """Whether all reports are processed, so that requests may follow from what is known."""
        return not self._backlog

    def check_position(self) -> None:
        """Check that the vehicle tells where it is, and when.

        Raises:
            FlightEnded: Its link is up, and it has not for some seconds in flight; one that disarmed may
                have rebooted, and another check tells that. Or its clock jumped ahead.
        """
        if self._clock_jump_s:
            raise flight_ended.clock_jumped(self._clock_jump_s)
        silent_wall_s = self.wall_s - self._state_wall_s
        if not self.armed or silent_wall_s < _NO_POSITION_WALL_S:
            return
        if self._heartbeats_since_state >= _NO_POSITION_HEARTBEATS:
            raise flight_ended.no_position(_NO_POSITION_HEARTBEATS)

    def begin_arming(self) -> None:
        """Arming is requested now: the vehicle may be armed from now on."""
        self.arm_requested, self.was_armed = True, False
        self._home = self.state

    def begin_phase(self) -> None:
        """Forget status texts and acks of the phase before."""
        self.reason = ""
        self._failed_checks.clear()
        self.requests.clear()

    def record_auto(self, mission: Mission) -> None:
        """Record positions, and items of a mission reached, from the moment that the vehicle enters AUTO."""
        self._recording = True
        self.mission = MissionCurrent(0)
        self.progress = MissionProgress(mission)

    def record_from_now(self) -> None:
        """Record positions from now on."""
        self.auto_start_s = self.time_s

    def _auto_entered(self) -> None:
        if self._recording and self.auto_start_s is None:
            self.auto_start_s = self.time_s
            if self._before_auto is not None:
                self.progress.begin(self._before_auto)

    def step(self, timeout_s: float = _STEP_WALL_S) -> None:
        """Process the next report, waiting for it up to the timeout.

        Raises:
            FlightEnded: The link stays lost, this program fails on it, or the vehicle left the expected mode
                or rebooted.
        """
        if not self._backlog:
            self._fetch(timeout_s)
        if self._backlog:
            self._process_next()
        if not self._backlog and self._link.check(self.emit):
            self.taken_over = self.taken_over or self.unexpected_mode
            chosen_mode = self.mode if self.unexpected_mode else None
            raise flight_ended.link_lost(self.silence, chosen_mode, may_be_armed=self.may_be_armed)

    def catch_up(self) -> None:
        """Process all reports that have arrived.

        Raises:
            FlightEnded: As ``step``.
        """
        self._fetch(0.0)
        while len(self._backlog) > 1:
            self._process_next()
        self.step(0.0)

    def _fetch(self, timeout_s: float) -> None:
        try:
            reports = self.vehicle.reports(timeout_s)
        except LinkFaultError as fault:
            raise flight_ended.internal_error(str(fault)) from fault
        if reports:
            self._link.received(self.emit)
        self._backlog.extend(reports)

    def _process_next(self) -> None:
        self._process(self._backlog.popleft())
        reason = self.failsafe_text
        if self.modes.taken_over(self.wall_s, explained=bool(reason)):
            self.taken_over = True
            if self.modes.is_failsafe or self._is_named(reason):
                raise flight_ended.failsafe(self.mode, reason)
            raise flight_ended.pilot(self.mode)

    def _is_named(self, reason: str) -> bool:
        """Whether a failsafe says that it chose this mode: "EKF Failsafe: changed to ALT_HOLD Mode".

        After another text, such as "Radio Failsafe - Continuing Auto", it is the pilot who changes the mode.
        """
        return f"changed to {self.mode}".lower() in reason.lower()

    @singledispatchmethod
    def _process(self, report: object) -> None:
        raise TypeError(f"unknown report: {report!r}")

    @_process.register
    def _(self, heartbeat: Heartbeat) -> None:
        self.armed = heartbeat.armed
        self._heartbeats_since_state += 1
        self.armed_state = self.state if heartbeat.armed else self.armed_state
        self.was_armed = self.was_armed or (self.arm_requested and heartbeat.armed)
        self.modes.heartbeat(heartbeat.mode, heartbeat.armed, self.wall_s)
        if self.modes.unexpected.count == 1:
            self._unexpected_s = self.link_up_s
        self.requests.heartbeat()
        if heartbeat.mode == "AUTO":
            self._auto_entered()
        else:
            self._before_auto = self.state

    @_process.register
    def _(self, state: VehicleState) -> None:
        if self.state is not None and self.wall_s - self._state_wall_s < _LINK_GAP_WALL_S:
            self._link_was_up(max(state.time_s - self.state.time_s, 0.0))
        self._check_jump(state)
        self.state, self._state_wall_s = state, self.wall_s
        self._heartbeats_since_state = 0
        self.modes.clock(state.time_s, self.wall_s)
        if self.auto_start_s is not None:
            self.flown.append(state)
        self.emit(state)
        held, self._held = self._held, []
        for report in held:
            self._process(report)

    def _link_was_up(self, step_s: float) -> None:
        if step_s > _CLOCK_JUMP_S:
            self._clock_jump_s = step_s if self.armed else 0.0
        else:
            self.link_up_s += step_s

    def _check_jump(self, state: VehicleState) -> None:
        if self.armed and self.state is not None and self._jumps.observe(self.state, state):
            self.emit(Notice(flight_ended.jumped(self._jumps.latest(state.time_s)), warning=True))

    @_process.register
    def _(self, text: StatusText) -> None:
        if text.severity <= Severity.WARNING and not self._is_of_next_arming(text.text):
            self.reason = self._failed_checks.with_others(text.text, self.wall_s)
        lower = text.text.lower()
        if any(word in lower for word in _FAILSAFE_TEXTS):
            self._failsafe_text, self._failsafe_s = text.text, self.time_s
        self.requests.told_of_disarming |= _DISARMING_TEXT in lower
        self.mission_replaced = self.mission_replaced or _NEW_MISSION_TEXT in lower
        self.emit(text)

    def _is_of_next_arming(self, text: str) -> bool:
        """Whether a text tells why the vehicle cannot be armed again, which is not why it disarmed."""
        return self.was_armed and text.startswith(_PREARM_TEXT)

    @_process.register
    def _(self, ack: RequestAck) -> None:
        self.requests.acked(ack)
        if ack.request is Request.MODE and ack.accepted:
            self._auto_entered()

    @_process.register
    def _(self, lost: RequestLost) -> None:
        self.requests.lost(lost.request)

    def _held_back(self, report: MissionCurrent | MissionItemReached) -> bool:
        """Whether a report of the mission waits for the position that follows it: none came for a while.

        From the last one before a silence nobody could have flown so far.
        """
        is_old = self.state is not None and self.wall_s - self._state_wall_s >= _LINK_GAP_WALL_S
        if is_old:
            self._held.append(report)
        return is_old

    @_process.register
    def _(self, current: MissionCurrent) -> None:
        if self._held_back(current):
            return
        if self.auto_start_s is None or self.state is None:
            # Where AUTO is about to begin, the number may be that of a mission before.
            self.mission = self.mission if self._recording else current
        elif not self.progress.is_outdated(current.seq, self.state):
            self.mission = current
            self._note_reached(self.progress.flies_to(current.seq, self.state, complete=current.complete))

    @_process.register
    def _(self, item: MissionItemReached) -> None:
        if not self._held_back(item):
            self.item_reached(item.seq)

    @_process.register
    def _(self, home: HomePosition) -> None:
        if moved := self._home_moves.told(home, self._home if self.armed else None, self.altitude_m):
            self.emit(Notice(moved, warning=True))

    @_process.register
    def _(self, prearm: PrearmStatus) -> None:
        self.prearm = prearm

    @_process.register
    def _(self, rebooted: Rebooted) -> None:
        raise flight_ended.rebooted()

    def item_reached(self, seq: int) -> None:
        """The vehicle told that it reached an item, or is seen to have."""
        if self.state is not None:
            self._note_reached(self.progress.reached_item(seq, self.state))

    def _note_reached(self, seqs: list[int]) -> None:
        for jump in self.progress.jumps[self._jumps_told :]:
            self.emit(Notice(jump, warning=True))
        self._jumps_told = len(self.progress.jumps)
        for seq, number in self.progress.waypoints_among(seqs):
            self.emit(WaypointReached(seq, self.time_s, number))
