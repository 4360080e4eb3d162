"""The checks before arming, with ArduCopter's texts (AP_Arming.cpp, AP_Arming_Copter.cpp).

They run once a second while disarmed; failures are sent every 30 s as "PreArm: ...", and after a
refused arm command as "Arm: ...".
"""

from __future__ import annotations

from flight_replay.events import Severity
from flight_replay.flight_modes import CopterMode
from flight_replay.simulator.autopilot.context import AutopilotContext
from flight_replay.simulator.autopilot.failsafes import Failsafes
from flight_replay.simulator.autopilot.modes import MANUAL_THROTTLE, NEEDS_POSITION, NO_ARMING

_CHECK_EVERY_S = 1.0
_REPORT_EVERY_S = 30.0
_AUTO_ALLOWS_ARMING = 1  # AUTO_OPTIONS


class Prearm:
    """Whether the vehicle could be armed now, and if not, why."""

    def __init__(self, autopilot: AutopilotContext, failsafes: Failsafes) -> None:
        self._autopilot, self._failsafes = autopilot, failsafes
        self._last_check_s = 0.0
        self._last_report_s = 0.0
        self.passed = False

    def update(self) -> None:
        """Check and report when it is time."""
        now_s = self._autopilot.time_s
        if self._autopilot.armed or now_s - self._last_check_s < _CHECK_EVERY_S:
            return
        self._last_check_s = now_s
        problems = self.problems()
        self.passed = not problems
        if problems and now_s - self._last_report_s >= _REPORT_EVERY_S:
            self.report_problems()

    def report_problems(self) -> None:
        """Send every failed check as a status text."""
        self._last_report_s = self._autopilot.time_s
        for problem in self.problems():
            self._autopilot.say(Severity.CRITICAL, f"PreArm: {problem}")

    def problems(self) -> list[str]:
        """The failed checks; with ARMING_CHECK 0 only the mandatory ones count."""
        autopilot = self._autopilot
        found = self._position_problems()
        if autopilot.mode not in MANUAL_THROTTLE and not autopilot.sensors.attitude_ok:
            found.append("Need Alt Estimate")
        if autopilot.faults.prearm_failure:
            found.append(autopilot.faults.prearm_failure)
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
        failed = {
            "Check ANGLE_MAX": not 1000 <= parameters["ANGLE_MAX"] <= 8000,
            "Check PILOT_SPEED_UP": parameters["PILOT_SPEED_UP"] <= 0,
            "Check FS_THR_VALUE": bool(parameters["FS_THR_ENABLE"]) and parameters["FS_THR_VALUE"] < 910,
            "FS_GCS_ENABLE=2 removed, see FS_OPTIONS": parameters["FS_GCS_ENABLE"] == 2,
        }
        return [text for text, has_failed in failed.items() if has_failed]

    def _failsafe_problems(self) -> list[str]:
        autopilot = self._autopilot
        battery = autopilot.battery.arming_problem()
        found = [f"Battery 1 {battery}"] if battery else []
        if autopilot.battery.failsafe:
            found.append("Battery failsafe")
        if self._failsafes.gcs_lost:
            found.append("GCS failsafe on")
        return found

    def arm_problems(self, *, forced: bool) -> list[str]:
        """Why the arm command is refused, if it is; a forced one passes all but the mandatory checks."""
        if forced:
            return self._position_problems()
        return self.problems() or self._arm_check_problems()

    def _arm_check_problems(self) -> list[str]:
        """What is checked at the arm command only, up to the first failure (AP_Arming_Copter::arm_checks)."""
        autopilot = self._autopilot
        auto_allowed = int(autopilot.parameters["AUTO_OPTIONS"]) & _AUTO_ALLOWS_ARMING
        if not autopilot.sensors.attitude_ok:
            return ["AHRS not healthy"]
        if autopilot.mode in NO_ARMING or (autopilot.mode == CopterMode.AUTO and not auto_allowed):
            return [f"{autopilot.mode.name} mode not armable"]
        return [autopilot.faults.arm_failure] if autopilot.faults.arm_failure else []
