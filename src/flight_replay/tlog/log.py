"""Reads a log: which vehicles it holds, and the usable fixes of one of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flight_replay.errors import LogError
from flight_replay.geodesy import Floats
from flight_replay.tlog import source
from flight_replay.tlog.believable import REASONS, Verdict, judge
from flight_replay.tlog.clock import read_clock
from flight_replay.tlog.columns import AnyColumns, Heartbeats, Positions, Records
from flight_replay.tlog.scan import scan
from flight_replay.track import Armed, Track


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


@dataclass(frozen=True, slots=True)
class Log:
    """What a log holds of one vehicle.

    ``bytes`` counts the log's bytes, unpacked; ``vehicles`` are all that sent positions, the one
    with most usable fixes first; ``without_position`` counts the chosen vehicle's records at
    latitude and longitude 0, ``rejected`` those that cannot be believed, by reason.
    """

    path: str
    bytes: int
    vehicles: tuple[VehicleCount, ...]
    vehicle: VehicleCount
    track: Track
    without_position: int
    rejected: Mapping[str, int]

    @property
    def rejected_total(self) -> int:
        """How many positions were not believable."""
        return sum(self.rejected.values())


def read_log(
    path: Path | str,
    *,
    vehicle: VehicleId | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Log:
    """Read the usable fixes of a vehicle, by default the one that has most.

    Args:
        path: A log, plain or packed with gzip, or ``-`` for standard input.
        vehicle: The vehicle to read; a system id alone means its component with most fixes.
        progress: Told the stored bytes read so far, and their number (0 where unknown).

    Raises:
        LogError: There is no such log, or nothing usable in it.
    """
    with source.opened(path) as opened:
        records, length = scan(opened, progress)
        name, head = opened.name, opened.head
    found = sorted(
        (_read_vehicle(records, int(key)) for key in np.unique(records.positions.vehicle)),
        key=lambda each: -each.count.fixes,
    )
    if not found:
        raise LogError(f"{name} {_nothing_of(records, head)}; name a telemetry log with --tlog")
    chosen = _choose(name, found, vehicle)
    return Log(
        path=name,
        bytes=length,
        vehicles=tuple(each.count for each in found),
        vehicle=chosen.count,
        track=_track(records, chosen),
        without_position=chosen.empty,
        rejected=chosen.rejected,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """One vehicle's usable positions in order of time, with their time and section."""

    key: int
    positions: Positions
    time_s: Floats
    section: NDArray[np.int32]
    empty: int
    rejected: dict[str, int]

    @property
    def count(self) -> VehicleCount:
        return VehicleCount(self.key >> 8, self.key & 255, len(self.positions))


def _read_vehicle(records: Records, key: int) -> _Found:
    """Judge the positions of the vehicle ``key`` (system id * 256 + component id)."""
    positions = _of(records.positions, key)
    clock = read_clock(positions)
    verdict = judge(positions, _of(records.fixes, key), clock)
    counts = np.bincount(verdict, minlength=len(Verdict))
    usable = clock.order[verdict[clock.order] == Verdict.NONE]
    return _Found(
        key,
        positions.select(usable),
        clock.time_s[usable],
        clock.section[usable],
        records.empty.get(key, 0),
        {reason: int(counts[kind]) for kind, reason in REASONS.items() if counts[kind]},
    )


def _of(columns: AnyColumns, key: int) -> AnyColumns:
    """The records of one vehicle."""
    return columns.select(columns.vehicle == key)


def _choose(name: str, found: list[_Found], wanted: VehicleId | None) -> _Found:
    """The vehicle wanted, or the first one."""
    there = ", ".join(f"{each.count.id} ({each.count.fixes} fixes)" for each in found)
    for each in found:
        if wanted is None or each.count.is_named(wanted):
            if not each.count.fixes:
                raise LogError(f"{name} {_nothing_usable(each)}; name another log with --tlog")
            return each
    raise LogError(f"{name} has no positions of vehicle {wanted}; choose with --vehicle from {there}")


def _nothing_usable(found: _Found) -> str:
    """Why a vehicle has no fix."""
    what = f"has no usable position of vehicle {found.count.id}: {found.empty} without a position"
    return ", ".join([what, *(f"{count} rejected ({reason})" for reason, count in found.rejected.items())])


def _nothing_of(records: Records, head: bytes) -> str:
    """Why a log has no position at all."""
    if len(records.heartbeats) or len(records.fixes):
        return "is a MAVLink log without any GLOBAL_POSITION_INT record"
    return source.what_it_is(head)


def _track(records: Records, found: _Found) -> Track:
    """A vehicle's fixes in SI units."""
    positions = found.positions
    return Track(
        time_s=found.time_s,
        lat_deg=positions.lat_e7 / 1e7,
        lon_deg=positions.lon_e7 / 1e7,
        alt_m=positions.alt_mm / 1e3,
        amsl_m=positions.amsl_mm / 1e3,
        north_m_s=positions.north_cm_s / 1e2,
        east_m_s=positions.east_cm_s / 1e2,
        up_m_s=positions.down_cm_s / -1e2,
        section=found.section,
        armed=_armed(positions, _autopilot(_of(records.heartbeats, found.key)), found.section),
    )


_NO_AUTOPILOT = 8  # MAV_AUTOPILOT_INVALID: ground stations, radios, gimbals and other components
_ARDUPILOT = 3  # MAV_AUTOPILOT_ARDUPILOTMEGA
# MAV_TYPE of what may share a vehicle's ids without being one: ground station, onboard controller,
# gimbal, ADS-B, camera to Open Drone ID, battery to winch, illuminator, gripper, radio.
_NO_VEHICLE_TYPES = np.array([6, 18, 26, 27, *range(30, 35), *range(36, 43), 44, 48, 49])


def _autopilot(heartbeats: Heartbeats) -> Heartbeats:
    """The heartbeats that an autopilot sent; ArduPilot's own where there are any: others may be made up."""
    is_vehicle = ~np.isin(heartbeats.type, _NO_VEHICLE_TYPES)
    kept = heartbeats.select((heartbeats.autopilot != _NO_AUTOPILOT) & is_vehicle)
    own = kept.autopilot == _ARDUPILOT
    return kept.select(own) if own.any() else kept


def _armed(positions: Positions, heartbeats: Heartbeats, section: NDArray[np.int32]) -> NDArray[np.int8]:
    """Whether the motors were armed at any time since the fix before, shape (n,), by the heartbeats.

    So a flight lasts from the first fix after they were reported armed to the first after disarmed.
    """
    told = np.append(heartbeats.armed.astype(np.int8), np.int8(Armed.UNKNOWN))
    armed = told[np.searchsorted(heartbeats.offset, positions.offset) - 1]
    armed[1:] = np.where(section[1:] == section[:-1], np.maximum(armed[1:], armed[:-1]), armed[1:])
    return np.asarray(armed)
