"""The vehicles of a log, by their MAVLink ids."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flight_replay.writing.counted import counted

_NAMED = 10


@dataclass(frozen=True, slots=True)
class VehicleId:
    """A MAVLink system id, and a component id where one is asked for."""

    system: int
    component: int | None = None

    def __str__(self) -> str:
        return str(self.system) if self.component is None else f"{self.system}:{self.component}"


@dataclass(frozen=True, slots=True)
class VehicleCount:
    """A vehicle that sent positions, and how many of them are usable."""

    system: int
    component: int
    fixes: int

    @property
    def id(self) -> VehicleId:
        """The vehicle's name."""
        return VehicleId(self.system, self.component)

    def is_named(self, wanted: VehicleId) -> bool:
        """Whether ``wanted`` means this vehicle."""
        return self.system == wanted.system and wanted.component in (None, self.component)


def vehicles_text(vehicles: Sequence[VehicleCount]) -> str:
    """The first ten vehicles with their fixes, and how many there are besides; empty if there are none."""
    named = [f"{each.id} ({counted(each.fixes, 'fix')})" for each in vehicles[:_NAMED]]
    if len(vehicles) > _NAMED:
        named.append(f"{len(vehicles) - _NAMED} more")
    return ", ".join(named)
