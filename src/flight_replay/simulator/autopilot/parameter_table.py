"""The copter's parameters: ArduCopter 4.6's names, order, types and defaults, kept in memory.

``parameters.csv`` holds what an ArduCopter 4.6 SITL answered to PARAM_REQUEST_LIST. Those that
the flight model, the checks or the failsafes read take effect at once; the others are stored
and answered only, so that ground stations find what they look for.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterator, Mapping, Set
from dataclasses import dataclass
from importlib.resources import files

from flight_replay.simulator.mission.stored_params import float32

_TYPES = {"int8": 2, "int16": 4, "int32": 6, "real32": 9}
_REAL = 9
_ROUNDING = 0.01  # so that 2.9999 becomes 3
_INTEGER_LIMITS = {2: (-(2**7), 2**7 - 1), 4: (-(2**15), 2**15 - 1), 6: (-(2**31), 2**31 - 1)}


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter: ``param_type`` is its MAV_PARAM_TYPE."""

    name: str
    param_type: int
    value: float


def stored_value(value: float, param_type: int) -> float:
    """``value`` as a parameter of that MAV_PARAM_TYPE stores it: an integer within limits, or a 32-bit float.

    Source: AP_Param::set_float.
    """
    if param_type not in _INTEGER_LIMITS:
        return float32(value)
    low, high = _INTEGER_LIMITS[param_type]
    return float(min(max(int(value + math.copysign(_ROUNDING, value)), low), high))


class Parameters(Mapping[str, float]):
    """Values by name, in the autopilot's order; ``on_change`` is called with each new value."""

    def __init__(
        self,
        values: Mapping[str, float] | None = None,
        renamed: Mapping[str, tuple[str, float]] | None = None,
        absent: Set[str] = frozenset(),
    ) -> None:
        """ArduCopter 4.6's table with some values changed.

        Args:
            values: new values, by the names that this table has.
            renamed: for a newer firmware, new names and factors to the new unit, by 4.6 name. The 4.6
                names can still be read here, in 4.6's units, but stations do not see them.
            absent: names of 4.6 that an older firmware lacks.

        Raises:
            KeyError: for a name that is not in the table.
        """
        self._renamed = dict(renamed or {})
        self.on_change: list[Callable[[Parameter], None]] = []
        self._parameters: dict[str, Parameter] = {}
        with (
            files("flight_replay.simulator.autopilot")
            .joinpath("parameters.csv")
            .open(encoding="ascii") as lines
        ):
            for row in csv.DictReader(lines):
                if row["name"] not in absent:
                    self._add(row["name"], _TYPES[row["type"]], float(row["value"]))
        self._order = list(self._parameters)
        for name, value in (values or {}).items():
            self.assign(name, value)

    def _add(self, name: str, param_type: int, value: float) -> None:
        if name in self._renamed:
            name, factor = self._renamed[name]
            param_type, value = _REAL, value * factor
        self._parameters[name] = Parameter(name, param_type, stored_value(value, param_type))

    def __getitem__(self, name: str) -> float:
        if name in self._renamed:
            name, factor = self._renamed[name]
            return self._parameters[name].value / factor
        return self._parameters[name].value

    def __iter__(self) -> Iterator[str]:
        return iter(self._order)

    def __len__(self) -> int:
        return len(self._order)

    def find(self, name: str) -> Parameter | None:
        """The parameter of that name, if there is one."""
        return self._parameters.get(name)

    def at(self, index: int) -> Parameter | None:
        """The parameter at an index of the full list, if it is that long."""
        return self._parameters[self._order[index]] if 0 <= index < len(self._order) else None

    def assign(self, name: str, value: float) -> Parameter:
        """Set a parameter as its type stores it, and call ``on_change``; KeyError for an unknown name."""
        old = self._parameters[name]
        new = Parameter(name, old.param_type, stored_value(value, old.param_type))
        self._parameters[name] = new
        for listener in self.on_change:
            listener(new)
        return new
