"""Changes of the flight mode: which are refused, and what they start (Copter::set_mode)."""

from __future__ import annotations

from flight_replay.events import Severity
from flight_replay.flight_modes import CopterMode
from flight_replay.simulator.autopilot.context import AutopilotContext
from flight_replay.simulator.autopilot.mission_control import MissionControl
from flight_replay.simulator.autopilot.modes import NEEDS_POSITION, SIMULATED, is_blocked


class ModeSwitch:
    """The flight mode."""

    def __init__(self, autopilot: AutopilotContext, mission: MissionControl) -> None:
        self._autopilot, self._mission = autopilot, mission
        self.mode = CopterMode.STABILIZE

    def request(self, number: int) -> bool:
        """Enter a mode that a station asks for by its number; whether it was entered."""
        autopilot = self._autopilot
        if number not in SIMULATED:
            autopilot.say(Severity.WARNING, f"No such mode {number}")
            return False
        mode = CopterMode(number)
        if is_blocked(mode, int(autopilot.parameters["FLTMODE_GCSBLOCK"])):
            return self._refuse(mode, "GCS entry disabled (FLTMODE_GCSBLOCK)")
        reason = autopilot.faults.refused_modes.get(number)
        return self.enter(mode) if reason is None else self._refuse(mode, reason)

    def _refuse(self, mode: CopterMode, reason: str) -> bool:
        self._autopilot.say(Severity.WARNING, f"Mode change to {mode.name} failed: {reason}")
        return False

    def enter(self, mode: CopterMode) -> bool:
        """Enter a mode if it has what it needs; disarmed, any simulated mode may be entered."""
        autopilot = self._autopilot
        if mode == self.mode:
            return True
        if autopilot.armed and mode in NEEDS_POSITION and not autopilot.sensors.position_ok:
            return self._refuse(mode, "requires position")
        if mode == CopterMode.AUTO and not self._mission.may_begin():
            return self._refuse(mode, "init failed")
        before, self.mode = self.mode, mode
        if before == CopterMode.AUTO:
            self._mission.stop()
        autopilot.flight.enter_mode(mode)
        if mode == CopterMode.AUTO:
            self._mission.wait_to_start()
        autopilot.mode_entered()
        return True
