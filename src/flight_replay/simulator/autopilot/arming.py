"""Arming and disarming: the command, the checks, and when the motors stop by themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flight_replay.simulator.autopilot.modes import Mode

if TYPE_CHECKING:
    from flight_replay.simulator.autopilot.autopilot import Autopilot

_CRITICAL, _WARNING, _INFO = 2, 4, 6
_LANDS_ITSELF = frozenset({Mode.LAND, Mode.RTL, Mode.AUTO})
_SURE_AFTER_S = 4.0  # longer than the model takes to stop the motors when it lands by itself


class Arming:
    """The motors' state; ``arm`` answers as the command does, the flag may follow later."""

    def __init__(self, autopilot: Autopilot) -> None:
        self._autopilot = autopilot
        self.armed = False
        self._arms_at_s: float | None = None
        self._idle_since_s = 0.0
        self._flew = False

    def arm(self, *, forced: bool = False) -> bool:
        """Arm if the checks pass; with an old firmware's delay, which each repeat starts again."""
        vehicle = self._autopilot
        if self.armed:
            return True
        problems = vehicle.prearm.refusal(forced=forced)
        for problem in problems:
            vehicle.say(_CRITICAL, f"Arm: {problem}")
        if problems:
            return False
        if vehicle.parameters["ARMING_CHECK"] == 0 and not forced:
            vehicle.say(_WARNING, "Warning: Arming Checks Disabled")
        self._arms_at_s = vehicle.time_s + vehicle.faults.personality.arming_takes_s
        self._arm_when_due()
        return True

    def _arm_when_due(self) -> None:
        vehicle = self._autopilot
        if self._arms_at_s is None or vehicle.time_s < self._arms_at_s:
            return
        self._arms_at_s = None
        self.armed = True
        self._flew = False
        self._idle_since_s = vehicle.time_s
        vehicle.say(_INFO, "Arming motors")
        vehicle.flight.arm()
        if vehicle.home is not None:
            vehicle.set_home(vehicle.flight.position_m)
        vehicle.happenings.note("armed")

    def may_disarm(self) -> bool:
        """Whether a station may disarm: not while it flies."""
        return not self.armed or self._autopilot.flight.landed

    def disarm(self) -> None:
        """Stop the motors, whatever the copter does."""
        self._arms_at_s = None
        if not self.armed:
            return
        self.armed = False
        self._autopilot.say(_INFO, "Disarming motors")
        self._autopilot.flight.disarm()
        self._autopilot.mission.reset()

    def update(self) -> None:
        """Arm when due; disarm after a landing, or when nothing has happened for DISARM_DELAY seconds."""
        self._arm_when_due()
        if not self.armed:
            return
        vehicle = self._autopilot
        if not vehicle.flight.landed or vehicle.flight.taking_off:
            self._idle_since_s = vehicle.time_s
            self._flew = self._flew or not vehicle.flight.landed
            return
        if self._flew and not vehicle.flight.motors:
            self.disarm()
            return
        delay_s = min(max(vehicle.parameters["DISARM_DELAY"], 0), 127)
        idle_s = vehicle.time_s - self._idle_since_s
        landed_itself = self._flew and vehicle.mode in _LANDS_ITSELF and idle_s >= _SURE_AFTER_S
        if landed_itself or (delay_s > 0 and idle_s >= delay_s):
            self.disarm()
