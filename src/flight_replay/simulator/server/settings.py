"""What to simulate, as plain data that travels from one process to another, and how to open it."""

from __future__ import annotations

import base64
import pickle
import time
from dataclasses import dataclass, field

from flight_replay.errors import SimulatorError
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.autopilot.faults import Faults
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.server.addresses import parse_address
from flight_replay.simulator.server.endpoint import Endpoint


@dataclass(frozen=True, slots=True)
class Settings:
    """What to simulate, and where it can be reached."""

    start: Start
    listen: tuple[str, ...] = ("tcp:127.0.0.1:0",)
    parameters: dict[str, float] = field(default_factory=dict)
    faults: Faults = field(default_factory=Faults)

    def as_line(self) -> str:
        """One line of text."""
        return base64.b64encode(pickle.dumps(self)).decode() + "\n"


def settings_of(line: str) -> Settings:
    """Settings from ``Settings.as_line``; the line comes from the process that started this one."""
    settings = pickle.loads(base64.b64decode(line))
    assert isinstance(settings, Settings)
    return settings


def open_endpoint(settings: Settings) -> Endpoint:
    """An autopilot and its links, ready to run.

    Raises:
        SimulatorError: if a parameter is unknown or a link cannot be opened.
    """
    firmware = settings.faults.firmware
    try:
        parameters = firmware.parameter_table(settings.parameters)
    except KeyError as error:
        raise SimulatorError(
            f"the built-in copter has no parameter {error.args[0]}; check its name"
        ) from None
    autopilot = Autopilot(settings.start, parameters=parameters, faults=settings.faults, unix_s=time.time())
    return Endpoint(autopilot, [parse_address(each) for each in settings.listen])
