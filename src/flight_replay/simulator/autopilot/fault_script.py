"""Carries out the happenings of a fault script at their moments of the flight."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flight_replay.simulator.autopilot.faults import (
    Action,
    FailsafeMode,
    Happening,
    MoveItem,
    PilotMode,
    Reboot,
    SetParameter,
)
from flight_replay.simulator.autopilot.modes import Mode

if TYPE_CHECKING:
    from flight_replay.simulator.autopilot.autopilot import Autopilot

_WARNING = 4
_E7_PER_M = 1e7 / 111320.0


class Happenings:
    """Those of ``autopilot.faults`` that are still to come; each takes place once."""

    def __init__(self, autopilot: Autopilot) -> None:
        self._autopilot = autopilot
        self._waiting: list[Happening] = list(autopilot.faults.happenings)
        self._due: list[tuple[float, Action]] = []
        self._uploads = 0

    def note(self, moment: str) -> None:
        """A moment of the flight has come."""
        for happening in [each for each in self._waiting if each.moment == moment]:
            self._waiting.remove(happening)
            self._due.append((self._autopilot.time_s + happening.after_s, happening.action))

    def update(self) -> None:
        """Do what is due."""
        if self._autopilot.protocol.uploads > self._uploads:
            self._uploads = self._autopilot.protocol.uploads
            self.note("upload")
        now_s = self._autopilot.time_s
        ready = [action for at_s, action in self._due if at_s <= now_s]
        self._due = [(at_s, action) for at_s, action in self._due if at_s > now_s]
        for action in ready:
            self._do(action)

    def _do(self, action: Action) -> None:
        vehicle = self._autopilot
        match action:
            case PilotMode(mode):
                vehicle.set_mode(Mode(mode))
            case FailsafeMode(mode, text):
                vehicle.say(_WARNING, text)
                vehicle.set_mode(Mode(mode))
            case SetParameter(name, value):
                vehicle.parameters.assign(name, value)
            case Reboot():
                vehicle.reboot()
            case MoveItem(seq, north_m):
                item = vehicle.store.read(seq)
                if item is not None:
                    vehicle.store.write(seq, replace(item, lat_e7=item.lat_e7 + round(north_m * _E7_PER_M)))
