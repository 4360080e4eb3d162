"""Records of DataFlash messages as tables in SI units, whatever the firmware named their columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Floats
from flight_replay.logs.dataflash.message_rows import MessageRows
from flight_replay.logs.dataflash.message_tables import (
    ArmEvents,
    GpsPositions,
    LoggedColumns,
    LoggedHeadings,
    LoggedPositions,
    LoggedVelocities,
)

_ARMED_EVENT, _DISARMED_EVENT = 10, 11  # ids of EV, the same in all firmwares that write them
_HOME_ORIGIN = 1  # ORGN's type of home; 0 is the estimator's origin
_3D_FIX = 3
_EPOCH_OF_GPS_S = 315_964_800  # 1980-01-06 in Unix time
_WEEK_S = 604_800
# When UTC got behind GPS time by one more second, Unix time (IERS Bulletin C); 15 s before these.
_LEAP_SECONDS_S = np.array([1_341_100_800, 1_435_708_800, 1_483_228_800])
_EARLIEST_S, _LATEST_S = 946_684_800, 4_102_444_800  # 2000, before there were such logs, and 2100
_LONGEST_RUN_S = 1e8  # three years without a reboot
_FASTEST_M_S = 1000.0
_HIGHEST_M = 100_000.0
_FIRST_FIRMWARE_TIME = "TimeMS"


def positions(rows: MessageRows) -> LoggedPositions | None:
    """POS; None where a needed column is missing."""
    needed = _numbers(rows, "Lat", "Lng", "Alt")
    if needed is None:
        return None
    lat_deg, lon_deg, amsl_m = needed
    time_s = _where_height_is_possible(_time_s(rows), amsl_m)
    above_home_m = _bounded(_single(rows, "RelHomeAlt"), _HIGHEST_M)
    return LoggedPositions(rows.offset, time_s, lat_deg, lon_deg, _as_single(amsl_m), above_home_m)


def gps_positions(rows: MessageRows) -> GpsPositions | None:
    """GPS or GPS2; None where a needed column is missing."""
    needed = _numbers(rows, "Lat", "Lng", "Alt", "Status")
    if needed is None:
        return None
    lat_deg, lon_deg, amsl_m, status = needed
    instance = _or(rows.number("I"), float(rows.name == "GPS2"), len(status))
    return GpsPositions(
        offset=rows.offset,
        time_s=_where_height_is_possible(_gps_time_s(rows), amsl_m),
        lat_deg=lat_deg,
        lon_deg=lon_deg,
        amsl_m=_as_single(amsl_m),
        above_home_m=_bounded(_single(rows, "RelAlt"), _HIGHEST_M),
        instance=np.nan_to_num(instance).clip(0, 127).astype(np.int8),
        is_used=_or(rows.number("U"), 0.0, len(status)) > 0,
        has_3d_fix=status >= _3D_FIX,
        ground_speed_m_s=_bounded(_single(rows, "Spd"), _FASTEST_M_S),
        course_deg=_bounded(_single(rows, "GCrs"), 360.0),
        down_m_s=_bounded(_single(rows, "VZ"), _FASTEST_M_S),
        utc_s=_utc_s(rows),
    )


def headings(rows: MessageRows) -> LoggedHeadings | None:
    """ATT; None where it has no yaw."""
    needed = _numbers(rows, "Yaw")
    if needed is None:
        return None
    heading_deg = _bounded(_as_single(needed[0]), 360.0) % 360.0
    return LoggedHeadings(rows.offset, _time_s(rows), heading_deg)


def velocities(rows: MessageRows) -> LoggedVelocities | None:
    """XKF1, NKF1 or EKF1; None where a needed column is missing."""
    needed = _numbers(rows, "VN", "VE", "VD")
    if needed is None:
        return None
    return LoggedVelocities(
        rows.offset, _time_s(rows), *(_bounded(_as_single(column), _FASTEST_M_S) for column in needed)
    )


def arm_events(rows: MessageRows) -> ArmEvents | None:
    """What EV or ARM say of arming; None where the column is missing."""
    is_event = rows.name == "EV"
    needed = _numbers(rows, "Id" if is_event else "ArmState")
    if needed is None:
        return None
    value = needed[0]
    armed = value == _ARMED_EVENT if is_event else value > 0
    table = ArmEvents(rows.offset, _time_s(rows), armed)
    return table.select(armed | (value == _DISARMED_EVENT)) if is_event else table


def home_origins(rows: MessageRows) -> LoggedColumns | None:
    """When ORGN says that home was set; None where the column is missing."""
    needed = _numbers(rows, "Type")
    if needed is None:
        return None
    return LoggedColumns(rows.offset, _time_s(rows)).select(needed[0] == _HOME_ORIGIN)


def plausible_time_s(time_s: Floats) -> Floats:
    """Times (n,), those that no autopilot's clock can have as not a number."""
    return np.where((time_s >= 0) & (time_s < _LONGEST_RUN_S), time_s, np.nan)


def _time_s(rows: MessageRows) -> Floats:
    """The records' times (n,), seconds since the autopilot booted, not a number where they have none."""
    for column, factor in ("TimeUS", 1e6), (_FIRST_FIRMWARE_TIME, 1e3):
        if (time := rows.number(column)) is not None:
            return plausible_time_s(time / factor)
    return np.full(len(rows.offset), np.nan)


def _gps_time_s(rows: MessageRows) -> Floats:
    """The times of GPS records: in 3.x T is the autopilot's clock, and TimeMS the receiver's."""
    time = rows.number("T")
    return _time_s(rows) if time is None else plausible_time_s(time / 1e3)


def _utc_s(rows: MessageRows) -> Floats:
    """Unix time by the receiver (n,), not a number where it can't be right."""
    for columns in ("GWk", "GMS"), ("Week", _FIRST_FIRMWARE_TIME):
        needed = _numbers(rows, *columns)
        if needed is not None:
            break
    else:
        return np.full(len(rows.offset), np.nan)
    gps_s = needed[0] * _WEEK_S + needed[1] / 1e3 + _EPOCH_OF_GPS_S - 15.0
    utc_s = gps_s - np.searchsorted(_LEAP_SECONDS_S, gps_s, "right")
    return np.where((utc_s > _EARLIEST_S) & (utc_s < _LATEST_S), utc_s, np.nan)


def _numbers(rows: MessageRows, *columns: str) -> Sequence[Floats] | None:
    """Columns of numbers, None if one is missing."""
    found = [rows.number(column) for column in columns]
    present = [column for column in found if column is not None]
    return present if len(present) == len(found) else None


def _single(rows: MessageRows, column: str) -> NDArray[np.float32]:
    """A column in single precision, which is enough for heights and velocities; else not a number."""
    return _as_single(_or(rows.number(column), np.nan, len(rows.offset)))


def _bounded(values: NDArray[np.float32], most: float) -> NDArray[np.float32]:
    """A column (n,), with what is beyond a bound both ways as not a number."""
    return np.where(np.abs(values) <= most, values, np.float32(np.nan))


def _where_height_is_possible(time_s: Floats, amsl_m: Floats) -> Floats:
    """Times (n,), not numbers where the record's height is that of no aircraft: nothing in it counts."""
    return np.where(np.abs(amsl_m) <= _HIGHEST_M, time_s, np.nan)


def _as_single(values: NDArray[Any]) -> NDArray[np.float32]:
    return values.astype(np.float32)


def _or(values: Floats | None, default: float, n: int) -> Floats:
    """A column, or a value for all of it."""
    return np.full(n, default) if values is None else values
