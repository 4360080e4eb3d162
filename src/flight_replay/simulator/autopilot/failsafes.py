"""Failsafes: battery and ground station, by ArduCopter's parameters (events.cpp)."""

from __future__ import annotations

from flight_replay.events import Severity
from flight_replay.flight_modes import CopterMode
from flight_replay.simulator.autopilot.battery import Level
from flight_replay.simulator.autopilot.context import AutopilotContext

# Options::GCS_CONTINUE_IF_AUTO and the other bits of FS_OPTIONS.
_GCS_CONTINUES_AUTO, _CONTINUES_LANDING, _GCS_CONTINUES_PILOT = 1 << 1, 1 << 3, 1 << 4
_PILOT_MODES = frozenset(
    {CopterMode.STABILIZE, CopterMode.ACRO, CopterMode.ALT_HOLD, CopterMode.LOITER, CopterMode.POSHOLD}
)
_NONE, _LAND, _RTL, _TERMINATE, _BRAKE_LAND = 0, 1, 2, 5, 7
# FS_GCS_ENABLE's values to actions; any other means RTL.
_GCS_ACTIONS = {4: _RTL, 5: _LAND, 7: _BRAKE_LAND}


class Failsafes:
    """What has tripped, and what was done about it."""

    def __init__(self, autopilot: AutopilotContext) -> None:
        self._autopilot = autopilot
        self._gcs_heard_s: float | None = None
        self.gcs_lost = False

    @property
    def any_active(self) -> bool:
        """Whether the heartbeat shows a critical state."""
        return self.gcs_lost or self._autopilot.battery.level > Level.FINE

    def hear_gcs(self) -> None:
        """A heartbeat of SYSID_MYGCS came in."""
        self._gcs_heard_s = self._autopilot.time_s

    def update(self) -> None:
        """Trip and clear failsafes by the vehicle's clock."""
        autopilot = self._autopilot
        if autopilot.armed and autopilot.battery.worsened(autopilot.time_s):
            self._battery_tripped()
        if autopilot.parameters["FS_GCS_ENABLE"] and self._gcs_heard_s is not None:
            lost = autopilot.time_s - self._gcs_heard_s > autopilot.parameters["FS_GCS_TIMEOUT"]
            if lost and not self.gcs_lost:
                self.gcs_lost = True
                self._gcs_tripped()
            elif self.gcs_lost and not lost:
                self.gcs_lost = False
                autopilot.say(Severity.WARNING, "GCS Failsafe Cleared")

    def _battery_tripped(self) -> None:
        autopilot, battery = self._autopilot, self._autopilot.battery
        level = "critical" if battery.level == Level.CRITICAL else "low"
        autopilot.say(
            Severity.WARNING,
            f"Battery 1 is {level} {battery.voltage_v:.2f}V used {battery.consumed_mah:.0f} mAh",
        )
        name = "BATT_FS_CRT_ACT" if battery.level == Level.CRITICAL else "BATT_FS_LOW_ACT"
        self._act("Battery", int(autopilot.parameters[name]))

    def _gcs_tripped(self) -> None:
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
            self._act("GCS", action)

    def _act(self, kind: str, action: int) -> None:
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
            self._fly(action)

    def _fly(self, action: int) -> None:
        autopilot = self._autopilot
        if action == _TERMINATE:
            autopilot.disarm()
        elif action == _LAND:
            autopilot.set_mode(CopterMode.LAND)
        elif action == _BRAKE_LAND:
            autopilot.set_mode(CopterMode.BRAKE)
        elif action != _NONE and not autopilot.set_mode(CopterMode.RTL):
            autopilot.set_mode(CopterMode.LAND)
