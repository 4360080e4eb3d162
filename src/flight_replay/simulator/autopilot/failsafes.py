"""Failsafes: battery and ground station, by ArduCopter's parameters (events.cpp)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flight_replay.simulator.autopilot.battery import Level
from flight_replay.simulator.autopilot.modes import Mode

if TYPE_CHECKING:
    from flight_replay.simulator.autopilot.autopilot import Autopilot

_WARNING = 4
# Options::GCS_CONTINUE_IF_AUTO and the other bits of FS_OPTIONS.
_GCS_CONTINUES_AUTO, _CONTINUES_LANDING, _GCS_CONTINUES_PILOT = 1 << 1, 1 << 3, 1 << 4
_PILOT_MODES = frozenset({Mode.STABILIZE, Mode.ACRO, Mode.ALT_HOLD, Mode.LOITER, Mode.POSHOLD})
_NONE, _LAND, _RTL, _TERMINATE, _BRAKE_LAND = 0, 1, 2, 5, 7
# FS_GCS_ENABLE's values to actions; any other means RTL.
_GCS_ACTIONS = {4: _RTL, 5: _LAND, 7: _BRAKE_LAND}


class Failsafes:
    """What has tripped, and what was done about it."""

    def __init__(self, autopilot: Autopilot) -> None:
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
        vehicle = self._autopilot
        if vehicle.armed and vehicle.battery.worsened(vehicle.time_s):
            self._battery_tripped()
        if vehicle.parameters["FS_GCS_ENABLE"] and self._gcs_heard_s is not None:
            lost = vehicle.time_s - self._gcs_heard_s > vehicle.parameters["FS_GCS_TIMEOUT"]
            if lost and not self.gcs_lost:
                self.gcs_lost = True
                self._gcs_tripped()
            elif self.gcs_lost and not lost:
                self.gcs_lost = False
                vehicle.say(_WARNING, "GCS Failsafe Cleared")

    def _battery_tripped(self) -> None:
        vehicle, battery = self._autopilot, self._autopilot.battery
        level = "critical" if battery.level == Level.CRITICAL else "low"
        vehicle.say(
            _WARNING,
            f"Battery 1 is {level} {battery.voltage_v:.2f}V used {battery.consumed_mah:.0f} mAh",
        )
        name = "BATT_FS_CRT_ACT" if battery.level == Level.CRITICAL else "BATT_FS_LOW_ACT"
        self._act("Battery", int(vehicle.parameters[name]))

    def _gcs_tripped(self) -> None:
        vehicle = self._autopilot
        options = int(vehicle.parameters["FS_OPTIONS"])
        action = _GCS_ACTIONS.get(int(vehicle.parameters["FS_GCS_ENABLE"]), _RTL)
        if not vehicle.armed:
            vehicle.say(_WARNING, "GCS Failsafe")
        elif vehicle.mode == Mode.AUTO and options & _GCS_CONTINUES_AUTO:
            vehicle.say(_WARNING, "GCS Failsafe - Continuing Auto Mode")
        elif vehicle.mode in _PILOT_MODES and options & _GCS_CONTINUES_PILOT:
            vehicle.say(_WARNING, "GCS Failsafe - Continuing Pilot Control")
        else:
            self._act("GCS", action)

    def _act(self, kind: str, action: int) -> None:
        vehicle = self._autopilot
        landing = vehicle.mode == Mode.LAND and int(vehicle.parameters["FS_OPTIONS"]) & _CONTINUES_LANDING
        if vehicle.flight.landed:
            vehicle.say(_WARNING, f"{kind} Failsafe - Disarming")
            vehicle.disarm()
        elif landing and action != _NONE:
            vehicle.say(_WARNING, f"{kind} Failsafe - Continuing Landing")
        else:
            vehicle.say(_WARNING, f"{kind} Failsafe")
            self._fly(action)

    def _fly(self, action: int) -> None:
        vehicle = self._autopilot
        if action == _TERMINATE:
            vehicle.disarm()
        elif action == _LAND:
            vehicle.set_mode(Mode.LAND)
        elif action == _BRAKE_LAND:
            vehicle.set_mode(Mode.BRAKE)
        elif action != _NONE and not vehicle.set_mode(Mode.RTL):
            vehicle.set_mode(Mode.LAND)
