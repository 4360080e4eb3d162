"""Arming and disarming: the command, the checks, and when the vehicle disarms itself."""

from __future__ import annotations

from flight_replay.events import Severity
from flight_replay.flight_modes import CopterMode
from flight_replay.simulator.autopilot.context import AutopilotContext
from flight_replay.simulator.autopilot.mission_control import MissionControl
from flight_replay.simulator.autopilot.prearm import Prearm

_LANDING_MODES = frozenset({CopterMode.LAND, CopterMode.RTL, CopterMode.AUTO})
_DISARMS_LANDED_S = 4.0  # longer than the flight model takes to stop the motors after a landing


class Arming:
    """The armed flag; ``arm`` answers as the command does, and the flag may follow later."""

    def __init__(self, autopilot: AutopilotContext, prearm: Prearm, mission: MissionControl) -> None:
        self._autopilot, self._prearm, self._mission = autopilot, prearm, mission
        self.armed = False
        self._arm_at_s: float | None = None
        self._idle_since_s = 0.0
        self._flew = False

    def arm(self, *, forced: bool = False) -> bool:
        """Arm if the checks pass; an old firmware arms after a delay, which every command starts again."""
        autopilot = self._autopilot
        if self.armed:
            return True
        problems = self._prearm.arm_problems(forced=forced)
        for problem in problems:
            autopilot.say(Severity.CRITICAL, f"Arm: {problem}")
        if problems:
            return False
        if autopilot.parameters["ARMING_CHECK"] == 0 and not forced:
            autopilot.say(Severity.WARNING, "Warning: Arming Checks Disabled")
        self._arm_at_s = autopilot.time_s + autopilot.faults.firmware.arming_delay_s
        self._arm_when_due()
        return True

    def _arm_when_due(self) -> None:
        autopilot = self._autopilot
        if self._arm_at_s is None or autopilot.time_s < self._arm_at_s:
            return
        self._arm_at_s = None
        self.armed = True
        self._flew = False
        self._idle_since_s = autopilot.time_s
        autopilot.say(Severity.INFO, "Arming motors")
        autopilot.flight.arm()
        if autopilot.home is not None and not autopilot.home_is_locked:
            autopilot.set_home(autopilot.flight.position_m)
        autopilot.trigger("armed")

    def may_disarm(self) -> bool:
        """Whether a station may disarm: not while the vehicle flies."""
        return not self.armed or self._autopilot.flight.landed

    def disarm(self) -> None:
        """Stop the motors, whatever the copter does."""
        self._arm_at_s = None
        if not self.armed:
            return
        self.armed = False
        self._autopilot.say(Severity.INFO, "Disarming motors")
        self._autopilot.flight.disarm()
        self._mission.reset()

    def update(self) -> None:
        """Arm when due; disarm after a landing, or after DISARM_DELAY seconds idle on the ground."""
        self._arm_when_due()
        if not self.armed:
            return
        autopilot = self._autopilot
        if not autopilot.flight.landed or autopilot.flight.taking_off:
            self._idle_since_s = autopilot.time_s
            self._flew = self._flew or not autopilot.flight.landed
            return
        if self._flew and not autopilot.flight.motors:
            self.disarm()
            return
        delay_s = min(max(autopilot.parameters["DISARM_DELAY"], 0), 127)
        idle_s = autopilot.time_s - self._idle_since_s
        landed_itself = self._flew and autopilot.mode in _LANDING_MODES and idle_s >= _DISARMS_LANDED_S
        if landed_itself or (delay_s > 0 and idle_s >= delay_s):
            self.disarm()
