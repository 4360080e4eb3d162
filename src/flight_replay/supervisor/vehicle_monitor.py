"""The supervisor's eyes: folds a vehicle's news into what is known now, and notices what must be noticed.

Two clocks: the vehicle's own times the flight (a simulator's may run 20 times faster), the one
here times silence. Nothing known outlives a silence: whoever waits, waits for new news. News is
taken one by one, so that what is concluded follows from its order and not from when this program
happened to run; nothing is commanded before all of it is taken.
"""

from __future__ import annotations

from collections import deque
from functools import singledispatchmethod

from flight_replay.events import Listener, StatusText, VehicleState, WaypointReached
from flight_replay.mission.items import FIRST_SEQ
from flight_replay.supervisor import interruptions
from flight_replay.supervisor.flight_plan import Deadlines
from flight_replay.supervisor.link_monitor import Silence
from flight_replay.supervisor.mode_monitor import Modes
from flight_replay.supervisor.request_tracker import Requests
from flight_replay.supervisor.vehicle_interface import (
    Answer,
    Clock,
    Heartbeat,
    ItemReached,
    MissionAt,
    News,
    Readiness,
    Rebooted,
    Request,
    Unanswered,
    Vehicle,
)

_STEP_S = 0.1  # Longest nap by the clock here; news ends it.
_WARNING = 4  # MAV_SEVERITY_WARNING: texts from here up are reasons, the rest is chatter.
_GAP_S = 1.0  # Between two position reports farther apart than this the vehicle was not heard.
_FAILSAFE_WORDS = ("failsafe", "breach", "crash")
_NEW_MISSION_WORDS = "flight plan received"  # Of ArduCopter 3.3 and later, when a mission was uploaded.
_WORDS_HOLD_S = 10.0  # Older words than this, by the vehicle's clock, are not the reason of a new mode.


class Watch:
    """What is known of the vehicle, and when it was learnt."""

    def __init__(self, vehicle: Vehicle, clock: Clock, listener: Listener, deadlines: Deadlines) -> None:
        self.vehicle = vehicle
        self.emit = listener
        self.deadlines = deadlines
        self._clock = clock
        self._silence = Silence(clock, deadlines)
        self._backlog: deque[News] = deque()
        self._state_wall_s = 0.0
        self.modes = Modes()
        self.armed: bool | None = None
        self.state: VehicleState | None = None
        self.readiness: Readiness | None = None
        self.mission = MissionAt(0)
        self.mission_replaced = False
        """Whether the vehicle said that it was given a mission, since what is on board was verified last."""
        self.reached: dict[int, float] = {}
        self.flown: list[VehicleState] = []
        self.attended_s = 0.0
        """Seconds of the vehicle's clock that went by while it was heard: what waits may count."""
        self.auto_start_s: float | None = None
        self._recording = False
        self.requests = Requests()
        self.arm_asked = self.was_armed = False
        self.reason = ""
        self._failsafe, self._failsafe_s = "", 0.0

    @property
    def mode(self) -> str | None:
        """The mode that the newest heartbeat shows."""
        return self.modes.mode

    @property
    def wall_s(self) -> float:
        """Seconds by the clock here."""
        return self._clock.monotonic_s()

    @property
    def time_s(self) -> float:
        """Seconds by the vehicle's clock, 0 before it told."""
        return self.state.time_s if self.state else 0.0

    @property
    def altitude_m(self) -> float:
        """Metres above home, 0 before the vehicle told."""
        return self.state.alt_m if self.state else 0.0

    @property
    def silence(self) -> str:
        """How long nothing was heard, in words, if the link is lost."""
        return self._silence.words

    @property
    def may_be_armed(self) -> bool:
        """Whether motors that we asked to run do, or may yet: an arming under way takes 3 s to show."""
        if not self.arm_asked or self.was_armed:
            return self.arm_asked and bool(self.armed)
        answer = self.requests.answers.get(Request.ARM)
        return answer is None or answer.accepted

    @property
    def surely_disarmed(self) -> bool:
        """Whether the vehicle says again and again that its motors do not run, and did not just reboot."""
        return self.modes.surely_disarmed(self.wall_s)

    @property
    def mode_in_doubt(self) -> bool:
        """Whether the newest heartbeat shows a mode that is not ours."""
        return self.modes.strange.beats > 0

    @property
    def caught_up(self) -> bool:
        """Whether all that was reported is taken in, so that what is known may be acted on."""
        return not self._backlog

    def begin_arming(self) -> None:
        """The motors may start from now on."""
        self.arm_asked, self.was_armed = True, False

    def forget_reason(self) -> None:
        """What comes from now on explains the step that begins now."""
        self.reason = ""
        self.requests.forget()

    def record_auto(self) -> None:
        """From the moment that the vehicle takes up AUTO, keep where it flies and what it reaches."""
        self._recording = True
        self.mission = MissionAt(0)
        self.reached.clear()

    def _in_auto(self) -> None:
        if self._recording and self.auto_start_s is None:
            self.auto_start_s = self.time_s

    def step(self, timeout_s: float = _STEP_S) -> None:
        """Take in the next thing that the vehicle reports, waiting briefly for it.

        Raises:
            Interrupted: The link stays lost, or the vehicle left the expected mode or rebooted.
        """
        if not self._backlog:
            self._fetch(timeout_s)
        if self._backlog:
            self._take_next()
        if not self._backlog and self._silence.check(self.emit):
            raise interruptions.link_lost(self.silence)

    def catch_up(self) -> None:
        """Take in all that was reported up to now.

        Raises:
            Interrupted: As ``step``.
        """
        self._fetch(0.0)
        while len(self._backlog) > 1:
            self._take_next()
        self.step(0.0)

    def _fetch(self, timeout_s: float) -> None:
        news = self.vehicle.news(timeout_s)
        if news:
            self._silence.heard(self.emit)
        self._backlog.extend(news)

    def _take_next(self) -> None:
        self._take(self._backlog.popleft())
        words = self._failsafe if self.time_s - self._failsafe_s <= _WORDS_HOLD_S else ""
        if self.modes.is_strange(self.wall_s, explained=bool(words)):
            own = self.modes.is_own
            raise interruptions.failsafe(self.mode, words) if own else interruptions.taken_over(self.mode)

    @singledispatchmethod
    def _take(self, news: object) -> None:
        raise TypeError(f"no such news: {news!r}")

    @_take.register
    def _(self, beat: Heartbeat) -> None:
        self.armed = beat.armed
        self.was_armed = self.was_armed or (self.arm_asked and beat.armed)
        self.modes.beat(beat.mode, beat.armed, self.wall_s)
        self.requests.beat()
        if beat.mode == "AUTO":
            self._in_auto()

    @_take.register
    def _(self, state: VehicleState) -> None:
        if self.state is not None and self.wall_s - self._state_wall_s < _GAP_S:
            self.attended_s += max(state.time_s - self.state.time_s, 0.0)
        self.state, self._state_wall_s = state, self.wall_s
        self.modes.clock_goes_on(state.time_s, self.wall_s)
        if self.auto_start_s is not None:
            self.flown.append(state)
        self.emit(state)

    @_take.register
    def _(self, text: StatusText) -> None:
        if text.severity <= _WARNING:
            self.reason = text.text
        words = text.text.lower()
        if any(word in words for word in _FAILSAFE_WORDS):
            self._failsafe, self._failsafe_s = text.text, self.time_s
        self.mission_replaced = self.mission_replaced or _NEW_MISSION_WORDS in words
        self.emit(text)

    @_take.register
    def _(self, answer: Answer) -> None:
        self.requests.answer(answer)
        if answer.request is Request.MODE and answer.accepted:
            self._in_auto()

    @_take.register
    def _(self, unanswered: Unanswered) -> None:
        self.requests.unanswered(unanswered.request)

    @_take.register
    def _(self, at: MissionAt) -> None:
        self.mission = at
        if self.auto_start_s is not None:
            self._reach_up_to(at.seq if at.complete else at.seq - 1)

    @_take.register
    def _(self, item: ItemReached) -> None:
        self._reach_up_to(item.seq)

    @_take.register
    def _(self, readiness: Readiness) -> None:
        self.readiness = readiness

    @_take.register
    def _(self, rebooted: Rebooted) -> None:
        self.readiness = None
        raise interruptions.rebooted()

    def _reach_up_to(self, last_seq: int) -> None:
        """Note an item and all before it: of a waypoint and the command behind it, one word is sent."""
        for seq in range(FIRST_SEQ, last_seq + 1):
            if seq not in self.reached:
                self.reached[seq] = self.time_s
                self.emit(WaypointReached(seq, self.time_s))
