"""Reads a log: which vehicles it holds, and the usable fixes of one of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flight_replay.errors import LogError
from flight_replay.geometry.arrays import Flags, Indices
from flight_replay.logs.tlog import byte_source
from flight_replay.logs.tlog.boot_clock import BootClock, read_clock
from flight_replay.logs.tlog.columns import AnyColumns, Fixes, Heartbeats, Positions, Records
from flight_replay.logs.tlog.plausibility import REASONS, Verdict, judge
from flight_replay.logs.tlog.scan import scan
from flight_replay.logs.tlog.vehicles import VehicleCount, VehicleId, armed_at
from flight_replay.logs.track import Track

MAX_VEHICLES = 1000
"""More in one log are noise or forged: judging each of the 65,025 that are possible would take minutes."""


@dataclass(frozen=True, slots=True)
class Log:
    """What a log holds of one vehicle.

    ``bytes`` counts the log's bytes, unpacked; ``vehicles`` are all that sent positions, the one
    with most usable fixes first; ``without_position`` counts the chosen vehicle's records at
    latitude and longitude 0, ``rejected`` the implausible ones, by reason.
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
    found = sorted(_read_vehicles(records, vehicle), key=lambda each: -each.count.fixes)
    if not found:
        raise LogError(f"{name} {_nothing_of(records, head)}; name a telemetry log with --tlog")
    chosen = _choose(name, found, vehicle)
    return Log(
        path=name,
        bytes=length,
        vehicles=tuple(each.count for each in found),
        vehicle=chosen.count,
        track=_track(chosen, records.heartbeats.select(records.heartbeats.vehicle == chosen.key)),
        without_position=chosen.empty,
        rejected=chosen.rejected,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """One vehicle's positions with their clock, and the indices of the ``usable`` ones in order of time."""

    key: int
    positions: Positions
    clock: BootClock
    usable: Indices
    empty: int
    rejected: dict[str, int]

    @property
    def count(self) -> VehicleCount:
        return VehicleCount(self.key >> 8, self.key & 255, len(self.usable))


def _read_vehicles(records: Records, wanted: VehicleId | None) -> Iterator[_Found]:
    """Each vehicle of the log; of more than ``MAX_VEHICLES``, the ones with most positions and the wanted."""
    counts = np.bincount(records.positions.vehicle)
    keys = np.flatnonzero(counts)
    if len(keys) > MAX_VEHICLES:
        is_most = np.zeros(len(keys), np.bool_)
        is_most[np.argsort(-counts[keys], kind="stable")[:MAX_VEHICLES]] = True
        keys = keys[is_most if wanted is None else is_most | _is_named(keys, wanted)]
    parts = zip(_split(records.positions, keys), _split(records.fixes, keys), strict=True)
    for key, (positions, fixes) in zip(keys.tolist(), parts, strict=True):
        yield _read_vehicle(key, positions, fixes, records.empty.get(key, 0))


def _is_named(keys: Indices, wanted: VehicleId) -> Flags:
    """Which of the keys ``wanted`` means."""
    named = keys >> 8 == wanted.system
    return np.asarray(named if wanted.component is None else named & (keys & 255 == wanted.component))


def _split(columns: AnyColumns, keys: Indices) -> Iterator[AnyColumns]:
    """The records of each of the vehicles ``keys``, each in the order of the log."""
    if len(keys) == 1:
        yield columns.select(columns.vehicle == keys[0])
        return
    order = np.argsort(columns.vehicle, kind="stable")
    bounds = np.searchsorted(columns.vehicle[order], np.stack([keys, keys + 1]).astype(np.int64))
    for first, end in bounds.T.tolist():
        yield columns.select(order[first:end])


def _read_vehicle(key: int, positions: Positions, fixes: Fixes, empty: int) -> _Found:
    """Judge the positions of the vehicle ``key`` (system id * 256 + component id)."""
    clock = read_clock(positions)
    verdict = judge(positions, fixes, clock)
    counts = np.bincount(verdict, minlength=len(Verdict))
    rejected = {reason: int(counts[kind]) for kind, reason in REASONS.items() if counts[kind]}
    usable = clock.in_order(verdict == Verdict.NONE)
    return _Found(key, positions, clock, usable, empty, rejected)


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


def _track(found: _Found, heartbeats: Heartbeats) -> Track:
    """A vehicle's fixes in SI units; ``heartbeats`` are its own."""
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
        armed=armed_at(positions.offset[at], boot, heartbeats),
    )
