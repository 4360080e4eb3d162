"""Reads and sets single parameters of the vehicle: a radio needs minutes for all 1,340 of them.

ArduCopter 4.7 renamed and rescaled many (ardupilot PR 32147); the table of both schemes is in
``simulator.dynamics.parameter_names``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress

from flight_replay.exceptions import VehicleError
from flight_replay.mavlink import Message, dialect
from flight_replay.simulator.dynamics.parameter_names import PARAMETERS
from flight_replay.vehicle.link import timesync
from flight_replay.vehicle.link.vehicle_link import Inbox, VehicleLink

_MIN_RETRY_S = 0.1  # ArduPilot reads parameters in a thread that is slower than its main loop.
_REQUEST_INTERVAL_S = 0.01  # Between requests, so that a slow radio keeps up.
_TOLERANCE = 1e-4  # Relative: parameters are float32.
_MAX_ERROR = 1e-3  # Probability of taking a lost answer for an unknown name.
_READ_S, _WRITE_S = 15.0, 10.0
_RESTORE_S, _RESTORE_UNANSWERED_S = 4.0, 1.0
_MAX_INTEGER_UNIT = 0.1
PutBack = Callable[[Mapping[str, str]], None]
"""Called when parameters were put back: why not, for each that the vehicle did not confirm."""
_UNANSWERED, _UNKNOWN = "the vehicle does not answer", "its firmware has no such parameter"


def read_parameters(link: VehicleLink, names: Iterable[str], limit_s: float = _READ_S) -> dict[str, float]:
    """Values by name; names that the vehicle does not have are left out.

    ArduPilot does not answer for a parameter that it does not have: a name counts as unknown when
    lost packets are a very unlikely cause, by how often a known name was answered meanwhile.
    """
    return _read(link, names, limit_s).values


def _read(link: VehicleLink, names: Iterable[str], limit_s: float) -> _ParameterReader:
    reader = _ParameterReader(link, list(dict.fromkeys(names)))
    end_s = link.now_s() + limit_s
    with link.inbox("PARAM_VALUE") as inbox:
        while reader.missing and not reader.missing_is_unknown and link.now_s() < end_s:
            reader.request_missing(inbox)
    return reader


def _retry_s(link: VehicleLink) -> float:
    return max(2 * link.round_trip.retry_s, _MIN_RETRY_S)


class _ParameterReader:
    """Rounds of requests for the missing parameters, each with one for a known parameter."""

    def __init__(self, link: VehicleLink, names: list[str]) -> None:
        self._link = link
        self._names = names
        self._rounds = self._answered = 0  # Rounds with a known name, and those in which it was answered.
        self._requested_s: dict[str, float] = {}  # When each name was first requested.
        self.values: dict[str, float] = {}

    @property
    def missing(self) -> list[str]:
        """The names without a value."""
        return [name for name in self._names if name not in self.values]

    @property
    def missing_is_unknown(self) -> bool:
        """Whether the vehicle does not have the missing names, rather than their packets being lost."""
        answer_rate = (self._answered + 1) / (self._rounds + 2)  # Laplace's rule of succession.
        return bool(self.values) and (1.0 - answer_rate) ** self._rounds < _MAX_ERROR

    def request_missing(self, inbox: Inbox) -> None:
        """Send one request for each missing name, and wait for the answers."""
        known = next(iter(self.values), None)
        requested = [*self.missing, known] if known else self.missing
        awaited = set(requested)
        timesync.ping(self._link)
        for name in requested:
            self._requested_s.setdefault(name, self._link.now_s())
            self._link.send(
                dialect.MAVLink_param_request_read_message(
                    self._link.system, self._link.component, name.encode(), -1
                )
            )
            self._take(inbox, awaited, self._link.now_s() + _REQUEST_INTERVAL_S)
        self._take(inbox, awaited, self._link.now_s() + _retry_s(self._link))
        if known:
            self._rounds += 1
            self._answered += known not in awaited

    def _take(self, inbox: Inbox, awaited: set[str], until_s: float) -> None:
        """Remove from ``awaited`` the names whose values come, until a time or until all came."""
        while awaited and (message := inbox.get(until_s - self._link.now_s())) is not None:
            if message.param_id in self._names:
                # ArduCopter 3.3 does not reply to TIMESYNC: nothing else measures the round trip there.
                if message.param_id in self._requested_s:
                    self._link.round_trip.estimated(self._link.now_s() - self._requested_s[message.param_id])
                self.values[message.param_id] = message.param_value
                awaited.discard(message.param_id)


def write_parameters(link: VehicleLink, wanted: Mapping[str, float], limit_s: float = _WRITE_S) -> None:
    """Set parameters, each confirmed by the vehicle.

    Raises:
        VehicleError: The vehicle does not confirm all values in time.
    """
    _check_set(wanted, _written(link, wanted, limit_s, math.inf))


def _check_set(wanted: Mapping[str, float], unset: Mapping[str, str]) -> None:
    for name, why in unset.items():
        raise VehicleError(f"cannot set parameter {name} to {wanted[name]:g}: {why}; check the link")


def set_parameters(
    link: VehicleLink, wanted: Mapping[str, float], known: Iterable[str] = ()
) -> dict[str, str]:
    """Set those of the parameters that the vehicle has; why not, for each that it does not confirm.

    A name that it is ``known`` to have soon shows which names it does not have.
    """
    reader = _read(link, [*wanted, *known], _READ_S)
    why = _UNKNOWN if reader.missing_is_unknown else _UNANSWERED
    unset = {name: why for name in reader.missing if name in wanted}
    there = {name: value for name, value in wanted.items() if name not in unset}
    return unset | _written(link, there, _WRITE_S, math.inf)


def _written(
    link: VehicleLink, wanted: Mapping[str, float], limit_s: float, unanswered_s: float
) -> dict[str, str]:
    """Set parameters; why not, for each that the vehicle does not confirm in time.

    One that never answers is left after ``unanswered_s``.
    """
    reported: dict[str, float] = {}
    began_s = link.now_s()
    end_s = began_s + min(limit_s, unanswered_s)
    with link.inbox("PARAM_VALUE") as inbox:
        while missing := [name for name, value in wanted.items() if not _equal(reported.get(name), value)]:
            if link.now_s() >= end_s:
                return {
                    name: f"it stays {reported[name]:g}" if name in reported else _UNANSWERED
                    for name in missing
                }
            for name in missing:
                link.send(_set_message(link, name, wanted[name]))
            retry_at_s = min(end_s, link.now_s() + _retry_s(link))
            while missing and (message := inbox.get(retry_at_s - link.now_s())) is not None:
                reported[message.param_id] = message.param_value
                end_s = began_s + limit_s
                missing = [name for name in missing if not _equal(reported.get(name), wanted[name])]
    return {}


def request_parameter(link: VehicleLink, name: str, value: float) -> None:
    """Request that a parameter is set, without waiting for the vehicle to confirm it."""
    link.send(_set_message(link, name, value))


def _equal(reported: float | None, value: float) -> bool:
    return reported is not None and math.isclose(reported, value, rel_tol=_TOLERANCE, abs_tol=_TOLERANCE)


def _set_message(link: VehicleLink, name: str, value: float) -> Message:
    return dialect.MAVLink_param_set_message(
        link.system, link.component, name.encode(), value, dialect.MAV_PARAM_TYPE_REAL32
    )


@contextmanager
def parameters_set(
    link: VehicleLink, wanted: Mapping[str, float], put_back: PutBack = lambda unset: None
) -> Iterator[None]:
    """Set parameters for as long as the context lasts, and restore their values on every way out.

    ``put_back`` is called after that.

    Raises:
        VehicleError: The vehicle has no such parameter, or does not accept or restore a value.
    """
    before = read_parameters(link, wanted)
    unknown = [name for name in wanted if name not in before]
    if unknown:
        raise VehicleError(
            f"the vehicle has no parameter {', '.join(unknown)}: its firmware is too old or too new, "
            "or the link loses its answers; check both"
        )

    def put_back_soon() -> None:
        """Put them back on an early way out: Ctrl-C has to end the program in 10 s, of which RTL may take 8.

        What led there is the error, not what the vehicle does not confirm.
        """
        with suppress(VehicleError):
            put_back(_written(link, before, _RESTORE_S, _RESTORE_UNANSWERED_S))

    try:
        write_parameters(link, wanted)
        yield
    except BaseException:
        put_back_soon()
        raise
    try:
        unset = _written(link, before, _WRITE_S, math.inf)
    except KeyboardInterrupt:
        put_back_soon()
        raise
    put_back(unset)
    _check_set(before, unset)


def limits_as_parameters(link: VehicleLink, limits: Mapping[str, float]) -> dict[str, float]:
    """Parameters in the vehicle's own names and units, for fields of ``Limits`` in SI units."""
    names = [name for name, (field, _) in PARAMETERS.items() if field in limits]
    known = read_parameters(link, names)
    return {name: _in_own_units(limits[PARAMETERS[name][0]], PARAMETERS[name][1]) for name in known}


def _in_own_units(value: float, scale: float) -> float:
    """A value in units of ``scale``, rounded if they are small: parameters in hundredths may be integers."""
    return float(round(value / scale)) if scale < _MAX_INTEGER_UNIT else value / scale
