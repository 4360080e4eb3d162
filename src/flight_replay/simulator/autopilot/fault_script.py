"""Carries out the fault script: what goes wrong in flight, and when."""

from __future__ import annotations

from dataclasses import replace

from flight_replay.events import Severity
from flight_replay.flight_modes import CopterMode
from flight_replay.simulator.autopilot.context import AutopilotContext
from flight_replay.simulator.autopilot.faults import (
    Action,
    FailsafeMode,
    MoveItem,
    PilotMode,
    Reboot,
    ScriptedFault,
    SetParameter,
)

_E7_PER_M = 1e7 / 111320.0


class FaultScript:
    """The scripted faults that are still to come; each takes place once."""

    def __init__(self, autopilot: AutopilotContext) -> None:
        self._autopilot = autopilot
        self._waiting: list[ScriptedFault] = list(autopilot.faults.script)
        self._due: list[tuple[float, Action]] = []

    def trigger(self, name: str) -> None:
        """Schedule the faults that wait for this trigger."""
        for fault in [each for each in self._waiting if each.trigger == name]:
            self._waiting.remove(fault)
            self._due.append((self._autopilot.time_s + fault.after_s, fault.action))

    def update(self) -> None:
        """Carry out what is due."""
        now_s = self._autopilot.time_s
        ready = [action for at_s, action in self._due if at_s <= now_s]
        self._due = [(at_s, action) for at_s, action in self._due if at_s > now_s]
        for action in ready:
            self._do(action)

    def _do(self, action: Action) -> None:
        autopilot = self._autopilot
        match action:
            case PilotMode(mode):
                autopilot.set_mode(CopterMode(mode))
            case FailsafeMode(mode, text):
                autopilot.say(Severity.WARNING, text)
                autopilot.set_mode(CopterMode(mode))
            case SetParameter(name, value):
                autopilot.parameters.assign(name, value)
            case Reboot():
                autopilot.reboot()
            case MoveItem(seq, north_m):
                item = autopilot.store.read(seq)
                if item is not None:
                    autopilot.store.write(seq, replace(item, lat_e7=item.lat_e7 + round(north_m * _E7_PER_M)))
