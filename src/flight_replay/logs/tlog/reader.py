"""Reads a telemetry log: which vehicles it holds, and the usable fixes of one of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from flight_replay.exceptions import LogError
from flight_replay.geometry.arrays import Flags, Floats, Indices
from flight_replay.logs.byte_source import OpenLog, Progress
from flight_replay.logs.plausibility import (
    RecordedPositions,
    Rejection,
    find_implausible,
    rejected_by_reason,
)
from flight_replay.logs.recording import Recording
from flight_replay.logs.tlog.arming.armed_state import armed_at, modes_at, moves_itself, vehicle_kind
from flight_replay.logs.tlog.arming.late_status import Arrivals, arrivals
from flight_replay.logs.tlog.climb_sign import with_climbs_as_heights
from flight_replay.logs.tlog.clock.boot_clock import BootClock, read_clock
from flight_replay.logs.tlog.clock.copies import copies
from flight_replay.logs.tlog.clock.stamps import plausible_utc_s
from flight_replay.logs.tlog.columns import AnyMessage, ArmingReports, Heartbeats, Positions, Records
from flight_replay.logs.tlog.gps_status import lacks_3d_fix
from flight_replay.logs.tlog.scan import scan
from flight_replay.logs.track import Track
from flight_replay.logs.unknown_content import describe
from flight_replay.logs.usable_fixes import why_no_fix
from flight_replay.logs.vehicles import VehicleCount, VehicleId, vehicles_text

_COPY = len(Rejection)  # beside the reasons of ``Rejection``: a copy is as plausible as the first
_FULL_TURN_CDEG = np.uint16(36_000)


def read_tlog(log: OpenLog, vehicle: VehicleId | None, progress: Progress | None) -> Recording:
    """Read the usable fixes of a vehicle, by default the one that has most.

    Args:
        log: A telemetry log.
        vehicle: The vehicle to read; a system id alone means its component with most fixes.
        progress: Told the stored bytes read so far, and their number (0 where unknown).

    Raises:
        LogError: There is nothing usable in it.
    """
    records, length = scan(log, progress)
    if not len(records.positions):
        raise LogError(f"{log.name} {_why_no_position(records, log)}; name a log of a flight")
    read = _judged(records)
    vehicles = read.vehicles()
    chosen = _choose(log.name, read, vehicles, vehicle)
    kind = vehicle_kind(read.heartbeats(chosen))
    return Recording(
        path=log.name,
        bytes=length,
        vehicles=vehicles,
        vehicle=chosen,
        track=read.track(chosen),
        without_position=read.without_position(chosen),
        rejected=read.rejected(chosen),
        modes=read.modes(chosen) if kind.firmware == "ArduPilot" else None,
        firmware=kind.firmware,
        vehicle_type=kind.name,
        is_multicopter=kind.is_multicopter,
        start_utc_s=read.start_utc_s(chosen),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Judged:
    """All that was read, one vehicle's after the other's, with the positions' clock and ``Rejection``.

    Positions that are there twice are a ``_COPY`` the second time.
    """

    records: Records
    clock: BootClock
    rejection: NDArray[np.int8]

    def vehicles(self) -> tuple[VehicleCount, ...]:
        """All that sent positions, the vehicle with most usable fixes first.

        Those with heartbeats of a vehicle are before those without any, and ground stations are last.
        """
        vehicle = self.records.positions.vehicle
        keys = np.flatnonzero(np.bincount(vehicle))
        fixes = np.bincount(vehicle[self.rejection == Rejection.NONE], minlength=1 << 16)[keys]
        counts = [
            VehicleCount(key >> 8, key & 255, n) for key, n in zip(keys.tolist(), fixes.tolist(), strict=True)
        ]
        return tuple(sorted(counts, key=self._rank))

    def _rank(self, vehicle: VehicleCount) -> tuple[bool, bool, bool, int]:
        """What is less for what is rather to be replayed."""
        moves = moves_itself(self.heartbeats(vehicle))
        return moves is False, vehicle.fixes == 0, moves is None, -vehicle.fixes

    def without_position(self, vehicle: VehicleCount) -> int:
        """How many of a vehicle's records are empty."""
        return self.records.empty.get(_key(vehicle), 0)

    def rejected(self, vehicle: VehicleCount) -> dict[str, int]:
        """How many of a vehicle's positions are implausible, by reason."""
        return rejected_by_reason(self.rejection[self._is_of(vehicle)])

    def track(self, vehicle: VehicleCount) -> Track:
        """A vehicle's fixes in SI units."""
        positions = self.records.positions
        at = self.clock.in_order(self._is_of(vehicle) & (self.rejection == Rejection.NONE))
        # The first fix keeps its vehicle's clock, and its boot is the first, whatever was before without one.
        time_s, boot = self.clock.time_s[at], self.clock.boot[at]
        time_s += positions.time_ms[at[0]] / 1e3 - time_s[0]
        boot -= boot[0]
        track = Track(
            time_s=time_s,
            lat_deg=positions.lat_e7[at] / 1e7,
            lon_deg=positions.lon_e7[at] / 1e7,
            alt_m=positions.alt_mm[at] / 1e3,
            amsl_m=positions.amsl_mm[at] / 1e3,
            north_m_s=positions.north_cm_s[at] / 1e2,
            east_m_s=positions.east_cm_s[at] / 1e2,
            up_m_s=positions.down_cm_s[at] / -1e2,
            heading_deg=_heading_deg(positions.heading_cdeg[at]),
            boot=boot,
            armed=armed_at(
                positions.offset[at],
                boot,
                self.heartbeats(vehicle),
                self.reports(vehicle),
                self.arrivals(vehicle),
            ),
        )
        return with_climbs_as_heights(track)

    def modes(self, vehicle: VehicleCount) -> NDArray[np.int16]:
        """The flight mode at each of a vehicle's fixes, shape (n,)."""
        at = self.clock.in_order(self._is_of(vehicle) & (self.rejection == Rejection.NONE))
        offset = self.records.positions.offset[at]
        return modes_at(offset, self.heartbeats(vehicle), self.arrivals(vehicle))

    def arrivals(self, vehicle: VehicleCount) -> Arrivals | None:
        """When a vehicle's positions came, None if none came late."""
        if self.clock.order is None:
            return None
        its = self._is_of(vehicle)
        return arrivals(self.records.positions.offset[its], self.clock.time_s[its])

    def heartbeats(self, vehicle: VehicleCount) -> Heartbeats:
        """All that came under the vehicle's ids."""
        heartbeats = self.records.heartbeats
        return heartbeats.select(heartbeats.vehicle == _key(vehicle))

    def reports(self, vehicle: VehicleCount) -> ArmingReports:
        """What came under the vehicle's ids of arming."""
        reports = self.records.reports
        return reports.select(reports.vehicle == _key(vehicle))

    def start_utc_s(self, vehicle: VehicleCount) -> float | None:
        """When the log was stamped at a vehicle's first fix, Unix time, if that is plausible."""
        first = self.clock.in_order(self._is_of(vehicle) & (self.rejection == Rejection.NONE))[0]
        return plausible_utc_s(int(self.records.positions.stamp_us[first]))

    def _is_of(self, vehicle: VehicleCount) -> Flags:
        """Which positions (n,) a vehicle sent."""
        return np.asarray(self.records.positions.vehicle == _key(vehicle))


def _key(vehicle: VehicleCount) -> int:
    """The vehicle's ids as one number."""
    return vehicle.system << 8 | vehicle.component


def _judged(records: Records) -> _Judged:
    """The records, of which there is one position at least, sorted by vehicle and judged."""
    positions = _by_vehicle(records.positions)
    gps, gps2 = _by_vehicle(records.gps), _by_vehicle(records.gps2)
    clock = read_clock(positions)
    recorded = RecordedPositions(
        time_s=clock.time_s,
        lat_deg=positions.lat_e7 / 1e7,
        lon_deg=positions.lon_e7 / 1e7,
        speed_m_s_at=partial(_speed_m_s, positions),
        boot=clock.boot,
        lacks_3d_fix=lacks_3d_fix(positions, gps, gps2, clock.time_s),
    )
    rejection = find_implausible(recorded, clock.order)
    rejection[copies(positions, clock)] = _COPY
    return _Judged(replace(records, positions=positions, gps=gps, gps2=gps2), clock, rejection)


def _by_vehicle(columns: AnyMessage) -> AnyMessage:
    """The records, those of each vehicle together, in the order of the log."""
    vehicle = columns.vehicle
    return (
        columns if (vehicle[1:] >= vehicle[:-1]).all() else columns.select(np.argsort(vehicle, kind="stable"))
    )


def _speed_m_s(positions: Positions, index: Indices) -> Floats:
    """Length of the reported velocity at some positions (m,)."""
    columns = positions.north_cm_s, positions.east_cm_s, positions.down_cm_s
    return np.asarray(np.sqrt(sum(column[index].astype(float) ** 2 for column in columns)) / 100)


def _heading_deg(heading_cdeg: NDArray[np.uint16]) -> Floats:
    """Headings (n,) from 0 to below 360; not a number where it says 65535: unknown."""
    return np.where(heading_cdeg <= _FULL_TURN_CDEG, heading_cdeg % _FULL_TURN_CDEG / 1e2, np.nan)


def _choose(
    name: str, read: _Judged, vehicles: Sequence[VehicleCount], wanted: VehicleId | None
) -> VehicleCount:
    """The vehicle wanted, or the first one."""
    named = [each for each in vehicles if wanted is None or each.is_named(wanted)]
    if named and named[0].fixes:
        return named[0]
    others = vehicles_text([each for each in vehicles if each.fixes])
    step = f"choose with --vehicle from {others}" if others else "name another log"
    why = f"has no positions of vehicle {wanted}"
    if named:
        left_out = why_no_fix(read.without_position(named[0]), read.rejected(named[0]))
        why = f"has no usable position of vehicle {named[0].id}: {left_out}"
    raise LogError(f"{name} {why}; {step}")


def _why_no_position(records: Records, log: OpenLog) -> str:
    """Why a log has no position at all."""
    if len(records.heartbeats) or len(records.gps):
        return "is a MAVLink log without any GLOBAL_POSITION_INT record"
    return describe(log.head, is_packed=log.is_packed)
