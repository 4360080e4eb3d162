"""The supervisor's eyes: folds a vehicle's news into what is known now, and notices what must be noticed.

Two clocks: the vehicle's own times the flight (a simulator's may run 20 times faster), the one
here times silence. Nothing known outlives a silence: whoever waits, waits for new news.
"""

from __future__ import annotations

from functools import singledispatchmethod

from flight_replay.events import Listener, StatusText, VehicleState, WaypointReached
from flight_replay.mission import FIRST_SEQ
from flight_replay.supervisor.contract import (
    Answer,
    Clock,
    Heartbeat,
    ItemReached,
    MissionAt,
    Readiness,
    Rebooted,
    Request,
    Vehicle,
)
from flight_replay.supervisor.plan import Deadlines
from flight_replay.supervisor.silence import Silence

_STEP_S = 0.1  # Longest nap by the clock here; news ends it.
_WARNING = 4  # MAV_SEVERITY_WARNING: texts from here up are reasons, the rest is chatter.
_GAP_S = 1.0  # Between two position reports farther apart than this the vehicle was not heard.
_STRANGE_BEATS = 2  # One heartbeat may be from before a change, on a link that mixes packets.
_REBOOT_SHOWS_S = 1.5  # A strange mode and disarmed is what a reboot looks like, until its clock tells.
_FAILSAFE_WORDS = ("failsafe", "breach", "crash")
_OWN_MODES = frozenset({"RTL", "SMART_RTL", "LAND", "BRAKE", "AUTO_RTL"})


class Interrupted(Exception):  # noqa: N818 - a turn of events, which only becomes an error in flight
    """The flight cannot go on as planned: ``ended`` and ``problem`` as in FlightRecord."""

    def __init__(self, ended: str, problem: str) -> None:
        super().__init__(problem)
        self.ended = ended
        self.problem = problem


class Watch:
    """What is known of the vehicle, and when it was learnt."""

    def __init__(self, vehicle: Vehicle, clock: Clock, listener: Listener, deadlines: Deadlines) -> None:
        self.vehicle = vehicle
        self.emit = listener
        self.deadlines = deadlines
        self._clock = clock
        self._silence = Silence(clock, deadlines)
        self._strange_beats = self._disarmed_beats = 0
        self._strange_s = self._disarmed_s = self._state_wall_s = 0.0
        self._ours: frozenset[str] = frozenset()
        self.mode: str | None = None
        self.armed: bool | None = None
        self.state: VehicleState | None = None
        self.readiness: Readiness | None = None
        self.mission = MissionAt(0)
        self.reached: dict[int, float] = {}
        self.flown: list[VehicleState] = []
        self.attended_s = 0.0
        """Seconds of the vehicle's clock that went by while it was heard: what waits may count."""
        self.auto_start_s: float | None = None
        self._recording = False
        self.answers: dict[Request, Answer] = {}
        self.arm_asked = self.was_armed = False
        self.reason = ""
        self.failsafe = ""

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
        answer = self.answers.get(Request.ARM)
        return answer is None or answer.accepted

    @property
    def surely_disarmed(self) -> bool:
        """Whether the vehicle says again and again that its motors do not run, and did not just reboot."""
        known_s = self.wall_s - self._disarmed_s
        return self._disarmed_beats >= _STRANGE_BEATS and known_s > _REBOOT_SHOWS_S

    @property
    def mode_in_doubt(self) -> bool:
        """Whether the newest heartbeat shows a mode that is not ours."""
        return self._strange_beats > 0

    def expect_mode(self, *modes: str) -> None:
        """From now on any other mode, told twice running, is somebody else's wish: ``Interrupted``."""
        self._ours = frozenset(modes)
        self._strange_beats = 0

    def begin_arming(self) -> None:
        """The motors may start from now on."""
        self.arm_asked, self.was_armed = True, False

    def forget_reason(self) -> None:
        """What comes from now on explains the step that begins now."""
        self.reason = ""
        self.answers.clear()

    def record_auto(self) -> None:
        """From the moment that the vehicle takes up AUTO, keep where it flies and what it reaches."""
        self._recording = True
        self.mission = MissionAt(0)
        self.reached.clear()

    def _in_auto(self) -> None:
        if self._recording and self.auto_start_s is None:
            self.auto_start_s = self.time_s

    def step(self, timeout_s: float = _STEP_S) -> None:
        """Take in what the vehicle reports, waiting briefly for it.

        Raises:
            Interrupted: The link stays lost, or the vehicle left the expected mode or rebooted.
        """
        news = self.vehicle.news(timeout_s)
        if news:
            self._silence.heard(self.emit)
        for item in news:
            self._take(item)
        if self._silence.check(self.emit):
            raise Interrupted(
                "link lost",
                f"the link to the vehicle is lost, {self.silence}; "
                "its own failsafe decides now: watch it, and check the link",
            )
        if self._mode_is_strange:
            self._explain_mode()

    @property
    def _mode_is_strange(self) -> bool:
        certain = self.armed or self.wall_s - self._strange_s > _REBOOT_SHOWS_S
        return self._strange_beats >= _STRANGE_BEATS and certain

    def _explain_mode(self) -> None:
        if self.mode in _OWN_MODES:
            why = f"by itself: {self.failsafe}" if self.failsafe else "without being asked to from here"
            raise Interrupted("failsafe", f"the vehicle changed to {self.mode} {why}; it was let go")
        raise Interrupted(
            "pilot",
            f"the mode was changed to {self.mode} by somebody else, who has control of the vehicle now",
        )

    @singledispatchmethod
    def _take(self, news: object) -> None:
        raise TypeError(f"no such news: {news!r}")

    @_take.register
    def _(self, beat: Heartbeat) -> None:
        self.mode, self.armed = beat.mode, beat.armed
        self.was_armed = self.was_armed or (self.arm_asked and beat.armed)
        self._disarmed_beats = 0 if beat.armed else self._disarmed_beats + 1
        if self._disarmed_beats == 1:
            self._disarmed_s = self.wall_s
        strange = bool(self._ours) and beat.mode not in self._ours
        self._strange_beats = self._strange_beats + 1 if strange else 0
        if self._strange_beats == 1:
            self._strange_s = self.wall_s
        if beat.mode == "AUTO":
            self._in_auto()

    @_take.register
    def _(self, state: VehicleState) -> None:
        if self.state is not None and self.wall_s - self._state_wall_s < _GAP_S:
            self.attended_s += max(state.time_s - self.state.time_s, 0.0)
        self.state, self._state_wall_s = state, self.wall_s
        if self.auto_start_s is not None:
            self.flown.append(state)
        self.emit(state)

    @_take.register
    def _(self, text: StatusText) -> None:
        if text.severity <= _WARNING:
            self.reason = text.text
        if any(word in text.text.lower() for word in _FAILSAFE_WORDS):
            self.failsafe = text.text
        self.emit(text)

    @_take.register
    def _(self, answer: Answer) -> None:
        self.answers[answer.request] = answer
        if answer.request is Request.MODE and answer.accepted:
            self._in_auto()

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
        raise Interrupted("reboot", "the autopilot rebooted; check why before flying again")

    def _reach_up_to(self, last_seq: int) -> None:
        """Note an item and all before it: of a waypoint and the command behind it, one word is sent."""
        for seq in range(FIRST_SEQ, last_seq + 1):
            if seq not in self.reached:
                self.reached[seq] = self.time_s
                self.emit(WaypointReached(seq, self.time_s))
