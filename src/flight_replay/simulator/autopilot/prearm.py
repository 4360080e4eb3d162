"""The checks before arming, with ArduCopter's words (AP_Arming.cpp, AP_Arming_Copter.cpp).

They run once a second while disarmed; failures are spoken every 30 s as "PreArm: ...", and at a
refused arm command as "Arm: ...".
"""

from __future__ import annotations

from flight_replay.events import Severity
from flight_replay.flight_modes import CopterMode
from flight_replay.simulator.autopilot.context import AutopilotContext
from flight_replay.simulator.autopilot.failsafes import Failsafes
from flight_replay.simulator.autopilot.modes import MANUAL_THROTTLE, NEEDS_POSITION, NO_ARMING

_EVERY_S = 1.0
_SAY_EVERY_S = 30.0
_AUTO_ALLOWS_ARMING = 1


class Prearm:
    """Whether the vehicle could be armed now, and if not, why."""

    def __init__(self, autopilot: AutopilotContext, failsafes: Failsafes) -> None:
        self._autopilot, self._failsafes = autopilot, failsafes
        self._checked_s = 0.0
        self._said_s = 0.0
        self.passed = False

    def update(self) -> None:
        """Check and speak when it is time."""
        now_s = self._autopilot.time_s
        if self._autopilot.armed or now_s - self._checked_s < _EVERY_S:
            return
        self._checked_s = now_s
        problems = self.problems()
        self.passed = not problems
        if problems and now_s - self._said_s >= _SAY_EVERY_S:
            self.say_problems()

    def say_problems(self) -> None:
        """Speak every failed check."""
        self._said_s = self._autopilot.time_s
        for problem in self.problems():
            self._autopilot.say(Severity.CRITICAL, f"PreArm: {problem}")

    def problems(self) -> list[str]:
        """The failed checks; with ARMING_CHECK 0 only the mandatory ones count."""
        autopilot = self._autopilot
        found = self._position_problems()
        if autopilot.mode not in MANUAL_THROTTLE and not autopilot.sensors.attitude_ok:
            found.append("Need Alt Estimate")
        if autopilot.faults.never_armable:
            found.append(autopilot.faults.never_armable)
        if autopilot.parameters["ARMING_CHECK"] == 0:
            return found
        if not autopilot.sensors.attitude_ok:
            found.append("EKF attitude is bad")
        if autopilot.mode == CopterMode.AUTO and len(autopilot.store) < 2:
            found.append("Mode requires mission")
        return found + self._parameter_problems() + self._failsafe_problems()

    def _position_problems(self) -> list[str]:
        sensors = self._autopilot.sensors
        if self._autopilot.mode not in NEEDS_POSITION:
            return []
        if sensors.fix_type < 3:
            return ["GPS 1: Bad fix"]
        if not sensors.origin_set:
            return ["AHRS: waiting for home"]
        return [] if sensors.position_ok else ["Need Position Estimate"]

    def _parameter_problems(self) -> list[str]:
        parameters = self._autopilot.parameters
        table = {
            "Check ANGLE_MAX": not 1000 <= parameters["ANGLE_MAX"] <= 8000,
            "Check PILOT_SPEED_UP": parameters["PILOT_SPEED_UP"] <= 0,
            "Check FS_THR_VALUE": bool(parameters["FS_THR_ENABLE"]) and parameters["FS_THR_VALUE"] < 910,
            "FS_GCS_ENABLE=2 removed, see FS_OPTIONS": parameters["FS_GCS_ENABLE"] == 2,
        }
        return [text for text, is_so in table.items() if is_so]

    def _failsafe_problems(self) -> list[str]:
        autopilot = self._autopilot
        battery = autopilot.battery.problem()
        found = [f"Battery 1 {battery}"] if battery else []
        if autopilot.battery.level:
            found.append("Battery failsafe")
        if self._failsafes.gcs_lost:
            found.append("GCS failsafe on")
        return found

    def refusal(self, *, forced: bool) -> list[str]:
        """Why the arm command is refused, if it is; a forced one meets the mandatory checks only."""
        if forced:
            return self._position_problems()
        return self.problems() or self._last_problems()

    def _last_problems(self) -> list[str]:
        """What is checked at the arm command only, up to the first failure (AP_Arming_Copter::arm_checks)."""
        autopilot = self._autopilot
        auto_may = int(autopilot.parameters["AUTO_OPTIONS"]) & _AUTO_ALLOWS_ARMING
        if not autopilot.sensors.attitude_ok:
            return ["AHRS not healthy"]
        if autopilot.mode in NO_ARMING or (autopilot.mode == CopterMode.AUTO and not auto_may):
            return [f"{autopilot.mode.name} mode not armable"]
        return [autopilot.faults.refuses_arming] if autopilot.faults.refuses_arming else []
