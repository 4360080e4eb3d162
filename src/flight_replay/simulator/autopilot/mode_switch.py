"""Entering flight modes: what is asked, what is refused, what follows (Copter::set_mode)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flight_replay.simulator.autopilot.modes import NEEDS_POSITION, Mode, is_blocked
from flight_replay.simulator.protocol import telemetry

if TYPE_CHECKING:
    from flight_replay.simulator.autopilot.autopilot import Autopilot

_WARNING = 4


class ModeSwitch:
    """The mode, and the ways to another."""

    def __init__(self, autopilot: Autopilot) -> None:
        self._autopilot = autopilot
        self.mode = Mode.STABILIZE

    def request(self, number: int) -> bool:
        """A station asks for a mode by its number."""
        vehicle = self._autopilot
        try:
            mode = Mode(number)
        except ValueError:
            vehicle.say(_WARNING, f"No such mode {number}")
            return False
        if is_blocked(mode, int(vehicle.parameters["FLTMODE_GCSBLOCK"])):
            return self._refuse(mode, "GCS entry disabled (FLTMODE_GCSBLOCK)")
        reason = vehicle.faults.refused_modes.get(number)
        return self.enter(mode) if reason is None else self._refuse(mode, reason)

    def _refuse(self, mode: Mode, reason: str) -> bool:
        self._autopilot.say(_WARNING, f"Mode change to {mode.name} failed: {reason}")
        return False

    def enter(self, mode: Mode) -> bool:
        """Enter a mode if what it needs is there; on the ground, disarmed, any mode may be chosen."""
        vehicle = self._autopilot
        if mode == self.mode:
            return True
        if vehicle.armed and mode in NEEDS_POSITION and not vehicle.sensors.position_ok:
            return self._refuse(mode, "requires position")
        if mode == Mode.AUTO and not vehicle.mission.may_begin():
            return self._refuse(mode, "init failed")
        before, self.mode = self.mode, mode
        if before == Mode.AUTO:
            vehicle.mission.stop()
        vehicle.flight.enter_mode(mode)
        if mode == Mode.AUTO:
            vehicle.mission.wait_to_start()
        vehicle.broadcast(telemetry.heartbeat(vehicle))
        vehicle.happenings.note(mode.name)
        return True
