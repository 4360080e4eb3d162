"""Failsafes: battery and ground station, by ArduCopter's parameters (events.cpp)."""

from __future__ import annotations

from flight_replay.events import Severity
from flight_replay.flight_modes import CopterMode
from flight_replay.simulator.autopilot.battery import BatteryFailsafe
from flight_replay.simulator.autopilot.context import AutopilotContext

# Options::GCS_CONTINUE_IF_AUTO and the other bits of FS_OPTIONS.
_GCS_CONTINUES_AUTO, _CONTINUES_LANDING, _GCS_CONTINUES_PILOT = 1 << 1, 1 << 3, 1 << 4
_PILOT_MODES = frozenset(
    {CopterMode.STABILIZE, CopterMode.ACRO, CopterMode.ALT_HOLD, CopterMode.LOITER, CopterMode.POSHOLD}
)
# Copter::FailsafeAction.
_NONE, _LAND, _RTL, _TERMINATE, _BRAKE_LAND = 0, 1, 2, 5, 7
# FS_GCS_ENABLE's values to actions; any other means RTL.
_GCS_ACTIONS = {4: _RTL, 5: _LAND, 7: _BRAKE_LAND}


class Failsafes:
    """Which failsafes are active, and what they do."""

    def __init__(self, autopilot: AutopilotContext) -> None:
        self._autopilot = autopilot
        self._gcs_heartbeat_s: float | None = None
        self.gcs_lost = False

    @property
    def any_active(self) -> bool:
        """Whether the heartbeat shows a critical state."""
        return self.gcs_lost or self._autopilot.battery.failsafe > BatteryFailsafe.NONE

    def gcs_heartbeat(self) -> None:
        """A heartbeat of the ground station SYSID_MYGCS has come."""
        self._gcs_heartbeat_s = self._autopilot.time_s

    def update(self) -> None:
        """Trigger and clear failsafes by the vehicle's clock."""
        autopilot = self._autopilot
        if autopilot.armed and autopilot.battery.failsafe_triggered(autopilot.time_s):
            self._battery_failsafe()
        if autopilot.parameters["FS_GCS_ENABLE"] and self._gcs_heartbeat_s is not None:
            lost = autopilot.time_s - self._gcs_heartbeat_s > autopilot.parameters["FS_GCS_TIMEOUT"]
            if lost and not self.gcs_lost:
                self.gcs_lost = True
                self._gcs_failsafe()
            elif self.gcs_lost and not lost:
                self.gcs_lost = False
                autopilot.say(Severity.WARNING, "GCS Failsafe Cleared")

    def _battery_failsafe(self) -> None:
        autopilot, battery = self._autopilot, self._autopilot.battery
        name = "critical" if battery.failsafe == BatteryFailsafe.CRITICAL else "low"
        autopilot.say(
            Severity.WARNING,
            f"Battery 1 is {name} {battery.voltage_v:.2f}V used {battery.consumed_mah:.0f} mAh",
        )
        action = "BATT_FS_CRT_ACT" if battery.failsafe == BatteryFailsafe.CRITICAL else "BATT_FS_LOW_ACT"
        self._trigger("Battery", int(autopilot.parameters[action]))

    def _gcs_failsafe(self) -> None:
        autopilot = self._autopilot
        options = int(autopilot.parameters["FS_OPTIONS"])
        action = _GCS_ACTIONS.get(int(autopilot.parameters["FS_GCS_ENABLE"]), _RTL)
        if not autopilot.armed:
            autopilot.say(Severity.WARNING, "GCS Failsafe")
        elif autopilot.mode == CopterMode.AUTO and options & _GCS_CONTINUES_AUTO:
            autopilot.say(Severity.WARNING, "GCS Failsafe - Continuing Auto Mode")
        elif autopilot.mode in _PILOT_MODES and options & _GCS_CONTINUES_PILOT:
            autopilot.say(Severity.WARNING, "GCS Failsafe - Continuing Pilot Control")
        else:
            self._trigger("GCS", action)

    def _trigger(self, kind: str, action: int) -> None:
        autopilot = self._autopilot
        landing = (
            autopilot.mode == CopterMode.LAND and int(autopilot.parameters["FS_OPTIONS"]) & _CONTINUES_LANDING
        )
        if autopilot.flight.landed:
            autopilot.say(Severity.WARNING, f"{kind} Failsafe - Disarming")
            autopilot.disarm()
        elif landing and action != _NONE:
            autopilot.say(Severity.WARNING, f"{kind} Failsafe - Continuing Landing")
        else:
            autopilot.say(Severity.WARNING, f"{kind} Failsafe")
            self._do(action)

    def _do(self, action: int) -> None:
        autopilot = self._autopilot
        if action == _TERMINATE:
            autopilot.disarm()
        elif action == _LAND:
            self._land()
        elif action == _BRAKE_LAND:
            autopilot.set_mode(CopterMode.BRAKE)
        elif action != _NONE and not autopilot.set_mode(CopterMode.RTL):
            self._land()

    def _land(self) -> None:
        """Land after a pause, in which a pilot may take over, unless the vehicle lands already."""
        if self._autopilot.mode != CopterMode.LAND and self._autopilot.set_mode(CopterMode.LAND):
            self._autopilot.flight.pause_landing()
