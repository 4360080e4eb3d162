"""Whose wish the mode is: ours, the vehicle's own, or a pilot's; told by heartbeats, in their order.

A reboot looks at first like a pilot who changed the mode and disarmed. What tells them apart is
the vehicle's clock, so nothing is concluded from a disarmed vehicle before its clock was heard.
"""

from __future__ import annotations

_ENOUGH_BEATS = 2  # One heartbeat may be from before a change, on a link that mixes packets.
_BEATS_WITHOUT_WORDS = 3  # The vehicle's reason comes behind the first heartbeat, or the second.
_REBOOT_SHOWS_S = 1.5  # By the clock here: reports older than this may be from before a reboot.
_CLOCK_SILENT_S = 6.0  # A vehicle that sends heartbeats and no clock for so long will send none.
_OWN_MODES = frozenset({"RTL", "SMART_RTL", "LAND", "BRAKE", "AUTO_RTL"})


class Suspicion:
    """Heartbeats in a row that show something that should not be."""

    def __init__(self) -> None:
        self.beats = 0
        self._since_s = 0.0
        self._clock_goes_on = False
        self.shows_s: float | None = None
        """The vehicle's time that was reported next after the first of them."""

    def beat(self, suspicious: bool, wall_s: float) -> None:
        """A heartbeat came, at ``wall_s`` by the clock here."""
        self.beats = self.beats + 1 if suspicious else 0
        if self.beats == 1:
            self._since_s, self._clock_goes_on, self.shows_s = wall_s, False, None

    def clock_goes_on(self, time_s: float, wall_s: float) -> None:
        """The vehicle reported a time that is later than all before."""
        if self.shows_s is None:
            self.shows_s = time_s
        if wall_s - self._since_s > _REBOOT_SHOWS_S:
            self._clock_goes_on = True

    def forget(self) -> None:
        """What was suspicious is so no more."""
        self.beats = 0

    def lasts_s(self, wall_s: float) -> float:
        """How long it has lasted by the clock here."""
        return wall_s - self._since_s if self.beats else 0.0

    def no_reboot(self, wall_s: float) -> bool:
        """Whether it is certain that the vehicle did not just reboot."""
        return self._clock_goes_on or wall_s - self._since_s > _CLOCK_SILENT_S


class Modes:
    """The mode, the modes that are expected, and what to make of another."""

    def __init__(self) -> None:
        self.mode: str | None = None
        self.strange, self.disarmed = Suspicion(), Suspicion()
        self.changed = False
        """Whether the mode that was asked for with ``expect_change`` has been entered."""
        self._ours: frozenset[str] = frozenset()
        self._wanted: str | None = None
        self._armed = False

    def expect(self, *modes: str) -> None:
        """From now on any other mode, told again and again, is somebody else's wish."""
        self._ours, self._wanted = frozenset(modes), None
        self.strange.forget()

    def expect_change(self, mode: str) -> None:
        """Expect a mode to be entered, and those expected so far until then.

        A heartbeat that already showed another mode goes on counting.
        """
        before = self._ours or frozenset([self.mode] if self.mode else [])
        self._wanted, self._ours = mode, before | {mode}
        self.changed = False
        if self.mode in self._ours:
            self.strange.forget()
        self._settle()

    def _settle(self) -> None:
        if self._wanted is not None and self.mode == self._wanted:
            self._ours, self._wanted, self.changed = frozenset({self._wanted}), None, True

    def beat(self, mode: str, armed: bool, wall_s: float) -> None:
        """A heartbeat came."""
        self.mode, self._armed = mode, armed
        self._settle()
        self.disarmed.beat(not armed, wall_s)
        self.strange.beat(bool(self._ours) and mode not in self._ours, wall_s)

    def clock_goes_on(self, time_s: float, wall_s: float) -> None:
        """The vehicle reported a time that is later than all before."""
        self.strange.clock_goes_on(time_s, wall_s)
        self.disarmed.clock_goes_on(time_s, wall_s)

    def is_strange(self, wall_s: float, *, explained: bool) -> bool:
        """Whether the mode surely is somebody else's wish; ``explained`` if the vehicle gave its reason."""
        own_without_words = self.is_own and not explained
        enough = _BEATS_WITHOUT_WORDS if own_without_words else _ENOUGH_BEATS
        return self.strange.beats >= enough and (self._armed or self.strange.no_reboot(wall_s))

    @property
    def is_own(self) -> bool:
        """Whether the mode is one that a vehicle enters by itself."""
        return self.mode in _OWN_MODES

    @property
    def disarmed_at_s(self) -> float | None:
        """When, by the vehicle's clock, it showed to have disarmed in a mode of ours; None if it has not."""
        if self.disarmed.beats < _ENOUGH_BEATS or self.strange.beats:
            return None
        return self.disarmed.shows_s

    def surely_disarmed(self, wall_s: float) -> bool:
        """Whether the motors do not run, and the vehicle did not just reboot."""
        return self.disarmed.beats >= _ENOUGH_BEATS and self.disarmed.no_reboot(wall_s)
