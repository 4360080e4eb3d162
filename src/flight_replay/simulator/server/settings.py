"""The settings of a simulator, as plain data that can be sent to another process."""

from __future__ import annotations

import base64
import pickle
import time
from dataclasses import dataclass, field

from flight_replay.exceptions import SimulatorError
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.autopilot.faults import Faults
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.server.addresses import parse_address
from flight_replay.simulator.server.endpoint import Endpoint


@dataclass(frozen=True, slots=True)
class Settings:
    """What to simulate, and the addresses to listen on."""

    start: Start
    listen: tuple[str, ...] = ("tcp:127.0.0.1:0",)
    parameters: dict[str, float] = field(default_factory=dict)
    faults: Faults = field(default_factory=Faults)

    def as_line(self) -> str:
        """One line of text."""
        return base64.b64encode(pickle.dumps(self)).decode() + "\n"


def settings_of(line: str) -> Settings:
    """Settings from ``Settings.as_line``, which only the process that started this one may have written."""
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
            f"the built-in copter has no parameter {error.args[0]}; check the name"
        ) from None
    autopilot = Autopilot(settings.start, parameters=parameters, faults=settings.faults, unix_s=time.time())
    return Endpoint(autopilot, [parse_address(each) for each in settings.listen])
