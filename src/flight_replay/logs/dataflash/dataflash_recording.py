"""The recording that a DataFlash log's records make."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flight_replay.exceptions import LogError
from flight_replay.geometry.arrays import Flags, Floats, Indices, Integers
from flight_replay.logs.dataflash.arm_history import armed_at, first_armed
from flight_replay.logs.dataflash.collected import ESTIMATORS, Collected
from flight_replay.logs.dataflash.home_heights import after_home_was_set, heights_above_home_m
from flight_replay.logs.dataflash.log_sections import (
    LogSections,
    SectionClocks,
    find_sections,
    joined_clocks,
)
from flight_replay.logs.dataflash.message_tables import (
    AnyTable,
    ArmEvents,
    GpsPositions,
    LoggedColumns,
    LoggedHeadings,
    LoggedPositions,
    LoggedVelocities,
)
from flight_replay.logs.dataflash.nearest_records import values_near
from flight_replay.logs.dataflash.position_source import PositionSource, choose_positions
from flight_replay.logs.dataflash.row_slices import slices
from flight_replay.logs.derived_velocity import with_derived_velocity
from flight_replay.logs.recording import Recording
from flight_replay.logs.track import Track, track_from_columns
from flight_replay.logs.usable_fixes import usable_fixes
from flight_replay.logs.vehicles import VehicleCount
from flight_replay.writing.counted import counted


@dataclass(frozen=True, slots=True, eq=False)
class LogContents:
    """What was read of a log of so many bytes, ``unread`` of which could not be read.

    ``restarts`` are the offsets at which FMT is defined.
    """

    name: str
    length: int
    unread: int
    collected: Collected
    restarts: Sequence[int]


def dataflash_recording(contents: LogContents) -> Recording:
    """The recording, with its track's implausible positions left out.

    Raises:
        LogError: There is no usable position, or the log is damaged beyond use.
    """
    tables = _tables(contents)
    source = choose_positions(tables.pos, tables.gps, tables.velocities, tables.sections)
    if not len(source.positions):
        raise LogError(
            f"{contents.name} has no usable position, but {counted(tables.damaged, 'damaged record')}; "
            "name a log of a flight"
        )
    vehicle = contents.collected.vehicle
    made = _track(source, tables, vehicle.logs_when_disarmed)
    notes = tuple(_notes(contents, tables, source, made))
    del source, tables  # their memory is as large as the track's
    usable = usable_fixes(made.track, made.lacks_3d_fix)
    if not len(usable.track):
        why = usable.why_none()
        raise LogError(f"{contents.name} has no usable position: {why}; name a log of a flight")
    track = with_derived_velocity(usable.track)
    count = None if vehicle.system_id is None else VehicleCount(vehicle.system_id, 1, len(track))
    kind = vehicle.kind
    return Recording(
        path=contents.name,
        bytes=contents.length,
        vehicles=() if count is None else (count,),
        vehicle=count,
        track=track,
        without_position=usable.without_position,
        rejected=usable.rejected,
        firmware=kind.firmware,
        vehicle_type=kind.name,
        is_multicopter=kind.is_multicopter,
        start_utc_s=made.utc_s(track),
        notes=notes,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Tables:
    """The records in the order of the log, without those whose time is damaged (``damaged`` positions)."""

    pos: LoggedPositions
    gps: GpsPositions
    velocities: LoggedVelocities
    headings: LoggedHeadings
    events: ArmEvents
    homes: LoggedColumns
    sections: LogSections
    damaged: int


def _tables(contents: LogContents) -> _Tables:
    """The tables of what was read.

    Raises:
        LogError: There is no position at all, or there are too many sections.
    """
    collected = contents.collected
    parts = collected.tables
    pos = _in_log_order(parts.joined("POS", LoggedPositions))
    gps = _in_log_order(parts.joined("GPS", GpsPositions))
    events = _in_log_order(parts.joined("events", ArmEvents))
    homes = _in_log_order(parts.joined("homes", LoggedColumns))
    headings = _in_log_order(parts.joined("headings", LoggedHeadings))
    if not len(pos) + len(gps):
        raise LogError(f"{contents.name} is a DataFlash log without any position; name a log of a flight")
    receivers = [gps.select(gps.instance == each) for each in np.unique(gps.instance)]
    sections = find_sections(contents.name, (pos, *receivers, events, homes), contents.restarts)
    good_pos, good_gps = pos.select(~sections.are_damaged(pos)), gps.select(~sections.are_damaged(gps))
    damaged = len(pos) + len(gps) - len(good_pos) - len(good_gps)
    velocities = {name: parts.joined(name, LoggedVelocities) for name in ESTIMATORS}
    chosen = collected.vehicle.estimator
    names = [name for name in (chosen, *ESTIMATORS) if name is not None and len(velocities[name])]
    used = _in_log_order(velocities[names[0] if names else ESTIMATORS[0]])
    return _Tables(good_pos, good_gps, used, headings, events, homes, sections, damaged)


def _in_log_order(table: AnyTable) -> AnyTable:
    """The rows by their place in the log, which messages of one kind but several names are not in."""
    falls = (np.diff(table.offset) < 0).any()
    return table.select(np.argsort(table.offset, kind="stable")) if falls else table


@dataclass(frozen=True, slots=True, eq=False)
class _MadeTrack:
    """All positions as a track, in the order of boot and time, and what is known of its clock."""

    track: Track
    lacks_3d_fix: Flags
    clocks: SectionClocks
    is_home_known: bool

    def utc_s(self, track: Track) -> float | None:
        """Unix time at the first of the track's fixes, where a receiver told it in that section."""
        section = int(track.boot[0])
        utc_s = float(self.clocks.utc_s[section] + track.time_s[0] - self.clocks.shift_s[section])
        return utc_s if np.isfinite(utc_s) else None


def _track(source: PositionSource, tables: _Tables, logs_when_disarmed: bool | None) -> _MadeTrack:
    """The positions of a source as a track."""
    positions, sections = source.positions, tables.sections
    used, section = _runs(sections.of(positions.offset))
    armed = armed_at(positions.offset, tables.events, sections, logs_when_disarmed)
    alt_m, is_home_known = _heights_m(source, tables, armed, section, used)
    heading_deg = values_near(positions, tables.headings, [tables.headings.heading_deg])[:, 0]
    order = _order(section, positions.time_s)
    time_s = positions.time_s[order]
    clocks = joined_clocks(section, time_s, tables.gps, _numbered(used, sections.of(tables.gps.offset)))
    for part in slices(len(time_s)):  # in place: the records' own times are needed no more
        time_s[part] += clocks.shift_s[section[part]]
    track = track_from_columns(
        np.maximum.accumulate(time_s, out=time_s),  # sums of sections may differ by their last bit
        positions.lat_deg[order],
        positions.lon_deg[order],
        alt_m[order],
        amsl_m=positions.amsl_m[order].astype(float),
        velocity_m_s=source.velocity_m_s[order],
        heading_deg=heading_deg[order],
        boot=section,
        armed=armed[order],
    )
    return _MadeTrack(track, source.lacks_3d_fix[order], clocks, is_home_known)


def _runs(section: Indices) -> tuple[Indices, NDArray[np.int32]]:
    """Which sections there are, and the number of each record's (n,) among them; sections do not fall."""
    begins = np.ones(len(section), np.bool_)
    begins[1:] = section[1:] != section[:-1]
    return section[begins], np.cumsum(begins, dtype=np.int32) - np.int32(1)


def _order(section: Integers, time_s: Floats) -> Indices | slice:
    """The order (n,) by section and time; records that are in it already need not be copied."""
    falls = (time_s[1:] < time_s[:-1]) & (section[1:] == section[:-1])
    return np.lexsort((time_s, section)) if falls.any() else slice(None)


def _heights_m(
    source: PositionSource,
    tables: _Tables,
    armed: NDArray[np.int8],
    section: Integers,
    used: Indices,
) -> tuple[Floats, bool]:
    """Heights above home (n,), and whether a home is known for all of them."""
    positions, counts = source.positions, source.counts
    told_m = _told_heights_m(positions, section, tables, used)
    if counts.all():
        return heights_above_home_m(positions.amsl_m, told_m, section, first_armed(section, armed))
    alt_m = np.full(len(positions), np.nan)
    alt_m[counts], is_home_known = heights_above_home_m(
        positions.amsl_m[counts],
        told_m[counts],
        section[counts],
        first_armed(section[counts], armed[counts]),
    )
    return alt_m, is_home_known


def _told_heights_m(
    positions: LoggedPositions, section: Integers, tables: _Tables, used: Indices
) -> NDArray[np.float32]:
    """Heights above home that the records tell (n,), not numbers before home was set."""
    if isinstance(positions, GpsPositions):
        return positions.above_home_m
    home_section = _numbered(used, tables.sections.of(tables.homes.offset))
    homes = tables.homes.select(home_section >= 0)
    is_told = after_home_was_set(positions.offset, section, homes.offset, home_section[home_section >= 0])
    return np.where(is_told, positions.above_home_m, np.float32(np.nan))


def _numbered(used: Indices, section: Integers) -> Indices:
    """Sections (n,) by their number among the used ones (m,), -1 for others."""
    if not len(used):
        return np.full(len(section), -1)
    number = np.minimum(np.searchsorted(used, section), len(used) - 1)
    return np.where(used[number] == section, number, -1)


def _notes(contents: LogContents, tables: _Tables, source: PositionSource, made: _MadeTrack) -> Iterator[str]:
    """What a person should know about how the log was read."""
    if contents.unread:
        yield f"{contents.unread} bytes could not be read"
    if tables.damaged:
        yield f"Positions left out because their time or height cannot be right: {tables.damaged}"
    if source.note:
        yield source.note
    if not made.is_home_known:
        yield "The log does not tell home; heights are above the first fix of each flight"
    firmwares = contents.collected.vehicle.firmwares
    if len(firmwares) > 1:
        yield f"The log is of more than one firmware: {', '.join(firmwares)}"
