"""Parameters of the vehicle, one by one: a radio needs minutes for all 1,340 of them.

ArduCopter 4.7 renamed and rescaled many (ardupilot PR 32147); the table of both schemes is in
``simulator.limits``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager

from flight_replay.errors import VehicleError
from flight_replay.simulator.limits import PARAMETERS
from flight_replay.vehicle.mavlink import Message, dialect
from flight_replay.vehicle.port import Inbox, Port

_SHORTEST_AGAIN_S = 0.1  # ArduPilot reads parameters in a thread that is slower than its main loop.
_PAUSE_S = 0.01  # Between requests, so that a slow radio keeps up.
_TOLERANCE = 1e-4  # Relative: parameters are float32.
_BEST_ODDS = 0.97  # However good the link seemed, two requests without an answer are few enough.
_DOUBT = 1e-3


def read_parameters(port: Port, names: Iterable[str], limit_s: float = 15.0) -> dict[str, float]:
    """Values by name; names that the vehicle does not have are left out.

    ArduPilot does not answer for a parameter that it does not have: a name counts as unknown when
    its silence is very unlikely to be lost packets, by how many other requests were answered.
    """
    reader = _Reader(port, list(dict.fromkeys(names)))
    end_s = port.now_s() + limit_s
    with port.inbox("PARAM_VALUE") as inbox:
        while reader.missing and not reader.sure and port.now_s() < end_s:
            reader.ask(inbox)
    return reader.values


def _again_s(port: Port) -> float:
    return max(2 * port.trip.again_s, _SHORTEST_AGAIN_S)


class _Reader:
    """Rounds of requests for what is missing."""

    def __init__(self, port: Port, names: list[str]) -> None:
        self._port = port
        self._names = names
        self._rounds = 0
        self._asked_for: dict[str, int] = {}
        self.values: dict[str, float] = {}

    @property
    def missing(self) -> list[str]:
        """The names without a value."""
        return [name for name in self._names if name not in self.values]

    @property
    def sure(self) -> bool:
        """Whether what is missing is unknown to the vehicle rather than lost on the way."""
        asked = sum(self._asked_for[name] for name in self.values)
        odds = min(len(self.values) / asked, _BEST_ODDS) if asked else 0.0
        return (1.0 - odds) ** self._rounds < _DOUBT

    def ask(self, inbox: Inbox) -> None:
        """One request for each missing name, and the time it takes to answer them."""
        self._rounds += 1
        for name in self.missing:
            self._asked_for[name] = self._rounds
            self._port.send(
                dialect.MAVLink_param_request_read_message(
                    self._port.system, self._port.component, name.encode(), -1
                )
            )
            self._take(inbox, self._port.now_s() + _PAUSE_S, until_all=False)
        self._take(inbox, self._port.now_s() + _again_s(self._port), until_all=True)

    def _take(self, inbox: Inbox, until_s: float, *, until_all: bool) -> None:
        while not (until_all and not self.missing):
            message = inbox.get(until_s - self._port.now_s())
            if message is None:
                return
            if message.param_id in self._asked_for:
                self.values[message.param_id] = message.param_value


def write_parameter(port: Port, name: str, value: float, limit_s: float = 10.0) -> None:
    """Set one parameter and see it confirmed.

    Raises:
        VehicleError: The vehicle does not confirm the value in time.
    """
    told: float | None = None
    end_s = port.now_s() + limit_s
    with port.inbox("PARAM_VALUE") as inbox:
        while port.now_s() < end_s:
            port.send(_set_message(port, name, value))
            again_s = min(end_s, port.now_s() + _again_s(port))
            while (message := inbox.get(again_s - port.now_s())) is not None:
                if message.param_id != name:
                    continue
                told = message.param_value
                if math.isclose(told, value, rel_tol=_TOLERANCE, abs_tol=_TOLERANCE):
                    return
    answer = "does not answer" if told is None else f"keeps {told:g}"
    raise VehicleError(f"parameter {name} cannot be set to {value:g}: the vehicle {answer}; check the link")


def _set_message(port: Port, name: str, value: float) -> Message:
    return dialect.MAVLink_param_set_message(
        port.system, port.component, name.encode(), value, dialect.MAV_PARAM_TYPE_REAL32
    )


@contextmanager
def parameters_set(port: Port, wanted: Mapping[str, float]) -> Iterator[None]:
    """Set parameters for a while, and put the old values back on every way out.

    Raises:
        VehicleError: The vehicle has no such parameter, or does not take a value or take it back.
    """
    before = read_parameters(port, wanted)
    unknown = [name for name in wanted if name not in before]
    if unknown:
        raise VehicleError(
            f"the vehicle has no parameter {', '.join(unknown)}; its firmware is too old or new"
        )
    try:
        for name, value in wanted.items():
            write_parameter(port, name, value)
        yield
    finally:
        for name, value in before.items():
            write_parameter(port, name, value)


def limits_as_parameters(port: Port, limits: Mapping[str, float]) -> dict[str, float]:
    """Parameters, in the vehicle's own naming scheme and units, that set fields of ``Limits`` (SI units)."""
    names = [name for name, (field, _) in PARAMETERS.items() if field in limits]
    there = read_parameters(port, names)
    return {name: limits[PARAMETERS[name][0]] / PARAMETERS[name][1] for name in there}
