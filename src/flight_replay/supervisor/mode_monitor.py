"""Who changed the flight mode (this program, the vehicle itself, or a pilot), judged by heartbeats in order.

A reboot looks at first like a pilot who changed the mode and disarmed. Only the vehicle's clock tells
the two apart, so a disarmed vehicle proves nothing until its clock has been received.
"""

from __future__ import annotations

from flight_replay.flight_modes import CopterMode

_MIN_HEARTBEATS = 2  # One heartbeat may be from before a change, on a link that reorders packets.
_MIN_HEARTBEATS_UNEXPLAINED = 3  # The status text with the reason follows the first or second heartbeat.
_REBOOT_WALL_S = 1.5  # Reports older than this may be from before a reboot.
_NO_CLOCK_WALL_S = 6.0  # A vehicle that sends heartbeats but no clock for so long will not send one.
_FAILSAFE_MODES = frozenset(
    mode.name
    for mode in (
        CopterMode.RTL,
        CopterMode.SMART_RTL,
        CopterMode.LAND,
        CopterMode.BRAKE,
        CopterMode.AUTO_RTL,
        CopterMode.AVOID_ADSB,
    )
)
"""The modes that the vehicle enters by itself; a pilot may choose all but the last, too."""


class UnexpectedHeartbeats:
    """Consecutive heartbeats that show something unexpected."""

    def __init__(self) -> None:
        self.count = 0
        self._since_wall_s = 0.0
        self._clock_advanced = False
        self.time_s: float | None = None
        """The first vehicle time that was reported after the first of them."""

    def heartbeat(self, unexpected: bool, wall_s: float) -> None:
        """A heartbeat came at the wall-clock time ``wall_s``."""
        self.count = self.count + 1 if unexpected else 0
        if self.count == 1:
            self._since_wall_s, self._clock_advanced, self.time_s = wall_s, False, None

    def clock(self, time_s: float, wall_s: float) -> None:
        """The vehicle reported a time later than all before."""
        if self.time_s is None:
            self.time_s = time_s
        if wall_s - self._since_wall_s > _REBOOT_WALL_S:
            self._clock_advanced = True

    def clear(self) -> None:
        """What was unexpected is expected from now on."""
        self.count = 0

    def reboot_excluded(self, wall_s: float) -> bool:
        """Whether a reboot cannot be their cause."""
        return self._clock_advanced or wall_s - self._since_wall_s > _NO_CLOCK_WALL_S


class ModeMonitor:
    """The flight mode, the modes that are expected, and whether somebody else changed it."""

    def __init__(self) -> None:
        self.mode: str | None = None
        self.unexpected, self.disarmed = UnexpectedHeartbeats(), UnexpectedHeartbeats()
        self.changed = False
        """Whether the mode requested with ``expect_change`` has been entered."""
        self._expected: frozenset[str] = frozenset()
        self._requested: str | None = None
        self._armed = False

    def expect(self, *modes: str) -> None:
        """Expect these modes only: any other that persists was chosen by somebody else."""
        self._expected, self._requested = frozenset(modes), None
        self.unexpected.clear()

    def expect_change(self, mode: str) -> None:
        """Expect a change to ``mode``, and until then the modes expected so far.

        Heartbeats that already showed another mode go on counting.
        """
        before = self._expected or frozenset([self.mode] if self.mode else [])
        self._requested, self._expected = mode, before | {mode}
        self.changed = False
        if self.mode in self._expected:
            self.unexpected.clear()
        self._check_changed()

    def _check_changed(self) -> None:
        if self._requested is not None and self.mode == self._requested:
            self._expected, self._requested, self.changed = frozenset({self._requested}), None, True

    def heartbeat(self, mode: str, armed: bool, wall_s: float) -> None:
        """A heartbeat came at the wall-clock time ``wall_s``."""
        self.mode, self._armed = mode, armed
        self._check_changed()
        self.disarmed.heartbeat(not armed, wall_s)
        self.unexpected.heartbeat(bool(self._expected) and mode not in self._expected, wall_s)

    def clock(self, time_s: float, wall_s: float) -> None:
        """The vehicle reported a time later than all before."""
        self.unexpected.clock(time_s, wall_s)
        self.disarmed.clock(time_s, wall_s)

    def taken_over(self, wall_s: float, *, explained: bool) -> bool:
        """Whether somebody else certainly chose the mode; ``explained`` if the vehicle gave a reason."""
        waits_for_reason = self.is_failsafe and not explained
        enough = _MIN_HEARTBEATS_UNEXPLAINED if waits_for_reason else _MIN_HEARTBEATS
        return self.unexpected.count >= enough and (self._armed or self.unexpected.reboot_excluded(wall_s))

    @property
    def is_failsafe(self) -> bool:
        """Whether the mode is one that a failsafe of the vehicle enters."""
        return self.mode in _FAILSAFE_MODES

    @property
    def disarmed_at_s(self) -> float | None:
        """Vehicle time at which it certainly had disarmed in an expected mode; None if it has not."""
        if self.disarmed.count < _MIN_HEARTBEATS or self.unexpected.count:
            return None
        return self.disarmed.time_s

    def certainly_disarmed(self, wall_s: float) -> bool:
        """Whether the vehicle is disarmed, and did not just reboot."""
        return self.disarmed.count >= _MIN_HEARTBEATS and self.disarmed.reboot_excluded(wall_s)
