"""Parameters of the vehicle, one by one: a radio needs minutes for all 1,340 of them.

ArduCopter 4.7 renamed and rescaled many (ardupilot PR 32147); the table of both schemes is in
``simulator.limits``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress

from flight_replay.errors import VehicleError
from flight_replay.mavlink import Message, dialect
from flight_replay.simulator.dynamics.limits import PARAMETERS
from flight_replay.vehicle.link import timesync
from flight_replay.vehicle.link.port import Inbox, Port

_SHORTEST_AGAIN_S = 0.1  # ArduPilot reads parameters in a thread that is slower than its main loop.
_PAUSE_S = 0.01  # Between requests, so that a slow radio keeps up.
_TOLERANCE = 1e-4  # Relative: parameters are float32.
_DOUBT = 1e-3  # Odds of taking a lost answer for an unknown name.
_PUT_BACK_S = 4.0
_SMALL_UNIT = 0.1


def read_parameters(port: Port, names: Iterable[str], limit_s: float = 15.0) -> dict[str, float]:
    """Values by name; names that the vehicle does not have are left out.

    ArduPilot does not answer for a parameter that it does not have: a name counts as unknown when
    its silence is very unlikely to be lost packets, by how often a known one was answered meanwhile.
    """
    reader = _Reader(port, list(dict.fromkeys(names)))
    end_s = port.now_s() + limit_s
    with port.inbox("PARAM_VALUE", timesync.KIND) as inbox:
        while reader.missing and not reader.sure and port.now_s() < end_s:
            reader.ask(inbox)
    return reader.values


def _again_s(port: Port) -> float:
    return max(2 * port.trip.again_s, _SHORTEST_AGAIN_S)


class _Reader:
    """Rounds of requests for what is missing, each with one for a name that is known to be there."""

    def __init__(self, port: Port, names: list[str]) -> None:
        self._port = port
        self._names = names
        self._rounds = self._answered = 0  # Rounds with a known name, and those in which it was answered.
        self._asked_s: dict[str, float] = {}  # When each name was asked for first.
        self.values: dict[str, float] = {}

    @property
    def missing(self) -> list[str]:
        """The names without a value."""
        return [name for name in self._names if name not in self.values]

    @property
    def sure(self) -> bool:
        """Whether what is missing is unknown to the vehicle rather than lost on the way."""
        odds = (self._answered + 1) / (self._rounds + 2)  # Laplace's rule of succession.
        return bool(self.values) and (1.0 - odds) ** self._rounds < _DOUBT

    def ask(self, inbox: Inbox) -> None:
        """One request for each missing name, and the time it takes to answer them."""
        known = next(iter(self.values), None)
        asked = [*self.missing, known] if known else self.missing
        awaited = set(asked)
        timesync.ping(self._port)
        for name in asked:
            self._asked_s.setdefault(name, self._port.now_s())
            self._port.send(
                dialect.MAVLink_param_request_read_message(
                    self._port.system, self._port.component, name.encode(), -1
                )
            )
            self._take(inbox, awaited, self._port.now_s() + _PAUSE_S)
        self._take(inbox, awaited, self._port.now_s() + _again_s(self._port))
        if known:
            self._rounds += 1
            self._answered += known not in awaited

    def _take(self, inbox: Inbox, awaited: set[str], until_s: float) -> None:
        """Strike from ``awaited`` what comes, until a time or until all came."""
        while awaited and (message := inbox.get(until_s - self._port.now_s())) is not None:
            if not timesync.learn(self._port, message) and message.param_id in self._names:
                # ArduCopter 3.3 sends no echoes: without this, waits for names it lacks would be guesses.
                if message.param_id in self._asked_s:
                    self._port.trip.guess(self._port.now_s() - self._asked_s[message.param_id])
                self.values[message.param_id] = message.param_value
                awaited.discard(message.param_id)


def write_parameters(port: Port, wanted: Mapping[str, float], limit_s: float = 10.0) -> None:
    """Set parameters and see each confirmed.

    Raises:
        VehicleError: The vehicle does not confirm all values in time.
    """
    told: dict[str, float] = {}
    end_s = port.now_s() + limit_s
    with port.inbox("PARAM_VALUE") as inbox:
        while missing := [name for name, value in wanted.items() if not _is(told.get(name), value)]:
            if port.now_s() >= end_s:
                raise VehicleError(_refused(missing[0], wanted[missing[0]], told.get(missing[0])))
            for name in missing:
                port.send(_set_message(port, name, wanted[name]))
            again_s = min(end_s, port.now_s() + _again_s(port))
            while missing and (message := inbox.get(again_s - port.now_s())) is not None:
                told[message.param_id] = message.param_value
                missing = [name for name in missing if not _is(told.get(name), wanted[name])]


def _is(told: float | None, value: float) -> bool:
    return told is not None and math.isclose(told, value, rel_tol=_TOLERANCE, abs_tol=_TOLERANCE)


def _refused(name: str, value: float, told: float | None) -> str:
    answer = "does not answer" if told is None else f"keeps {told:g}"
    return f"parameter {name} cannot be set to {value:g}: the vehicle {answer}; check the link"


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
        write_parameters(port, wanted)
        yield
    except BaseException:
        # What went wrong is what counts; and Ctrl-C has to end within 10 s.
        with suppress(VehicleError):
            write_parameters(port, before, _PUT_BACK_S)
        raise
    write_parameters(port, before)


def limits_as_parameters(port: Port, limits: Mapping[str, float]) -> dict[str, float]:
    """Parameters, in the vehicle's own naming scheme and units, that set fields of ``Limits`` (SI units)."""
    names = [name for name, (field, _) in PARAMETERS.items() if field in limits]
    there = read_parameters(port, names)
    return {name: _in_own_units(limits[PARAMETERS[name][0]], PARAMETERS[name][1]) for name in there}


def _in_own_units(value: float, scale: float) -> float:
    """A value in units of ``scale``, whole in small ones: parameters in hundredths may be integers."""
    return float(round(value / scale)) if scale < _SMALL_UNIT else value / scale
