"""Reads a log: which vehicles it holds, and the usable fixes of one of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flight_replay.errors import LogError
from flight_replay.geometry.arrays import Indices
from flight_replay.logs.tlog import byte_source
from flight_replay.logs.tlog.boot_clock import Clock, read_clock
from flight_replay.logs.tlog.columns import AnyColumns, Positions, Records
from flight_replay.logs.tlog.plausibility import REASONS, Verdict, judge
from flight_replay.logs.tlog.scan import scan
from flight_replay.logs.tlog.vehicles import VehicleCount, VehicleId, armed_at
from flight_replay.logs.track import Track


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
    with byte_source.opened(path) as opened:
        records, length = scan(opened, progress)
        name, head = opened.name, opened.head
    found = sorted(
        (_read_vehicle(records, int(key)) for key in np.flatnonzero(np.bincount(records.positions.vehicle))),
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
    """One vehicle's positions with their clock, and the indices of the ``usable`` ones in order of time."""

    key: int
    positions: Positions
    clock: Clock
    usable: Indices
    empty: int
    rejected: dict[str, int]

    @property
    def count(self) -> VehicleCount:
        return VehicleCount(self.key >> 8, self.key & 255, len(self.usable))


def _read_vehicle(records: Records, key: int) -> _Found:
    """Judge the positions of the vehicle ``key`` (system id * 256 + component id)."""
    positions = _of(records.positions, key)
    clock = read_clock(positions)
    verdict = judge(positions, _of(records.fixes, key), clock)
    counts = np.bincount(verdict, minlength=len(Verdict))
    rejected = {reason: int(counts[kind]) for kind, reason in REASONS.items() if counts[kind]}
    usable = clock.in_order(verdict == Verdict.NONE)
    return _Found(key, positions, clock, usable, records.empty.get(key, 0), rejected)


def _of(columns: AnyColumns, key: int) -> AnyColumns:
    """The records of one vehicle."""
    return columns.select(columns.vehicle == key)


def _choose(name: str, found: list[_Found], wanted: VehicleId | None) -> _Found:
    """The vehicle wanted, or the first one."""
    named = [each for each in found if wanted is None or each.count.is_named(wanted)]
    if named and named[0].count.fixes:
        return named[0]
    others = ", ".join(f"{each.count.id} ({each.count.fixes} fixes)" for each in found if each.count.fixes)
    step = f"choose with --vehicle from {others}" if others else "name another log with --tlog"
    lack = _nothing_usable(named[0]) if named else f"has no positions of vehicle {wanted}"
    raise LogError(f"{name} {lack}; {step}")


def _nothing_usable(found: _Found) -> str:
    """Why a vehicle has no fix."""
    why = [f"{count} rejected ({reason})" for reason, count in found.rejected.items()]
    if found.empty:
        why.insert(0, f"{found.empty} records are empty")
    return f"has no usable position of vehicle {found.count.id}: {', '.join(why)}"


def _nothing_of(records: Records, head: bytes) -> str:
    """Why a log has no position at all."""
    if len(records.heartbeats) or len(records.fixes):
        return "is a MAVLink log without any GLOBAL_POSITION_INT record"
    return byte_source.what_it_is(head)


def _track(records: Records, found: _Found) -> Track:
    """A vehicle's fixes in SI units."""
    positions, at = found.positions, found.usable
    # The first fix keeps its vehicle's clock, and its boot is the first, whatever was before without one.
    time_s, boot = found.clock.time_s[at], found.clock.boot[at]
    time_s += positions.time_ms[at[0]] / 1e3 - time_s[0]
    boot -= boot[0]
    return Track(
        time_s=time_s,
        lat_deg=positions.lat_e7[at] / 1e7,
        lon_deg=positions.lon_e7[at] / 1e7,
        alt_m=positions.alt_mm[at] / 1e3,
        amsl_m=positions.amsl_mm[at] / 1e3,
        north_m_s=positions.north_cm_s[at] / 1e2,
        east_m_s=positions.east_cm_s[at] / 1e2,
        up_m_s=positions.down_cm_s[at] / -1e2,
        boot=boot,
        armed=armed_at(positions.offset[at], boot, _of(records.heartbeats, found.key)),
    )
