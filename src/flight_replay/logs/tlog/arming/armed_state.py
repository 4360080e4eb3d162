"""Whether a vehicle was armed, its flight mode, and its kind, by its autopilot's heartbeats."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Indices
from flight_replay.logs.tlog.arming.arming_reports import with_reports
from flight_replay.logs.tlog.arming.late_status import Arrivals, without_late
from flight_replay.logs.tlog.columns import ArmingReports, Heartbeats
from flight_replay.logs.track import Armed
from flight_replay.logs.vehicle_kinds import VehicleKind, kind_of

_NO_AUTOPILOT = 8  # MAV_AUTOPILOT_INVALID: ground stations, radios, gimbals and other components
_AUTOPILOTS = {3: "ArduPilot", 12: "PX4"}  # MAV_AUTOPILOT_ARDUPILOTMEGA, MAV_AUTOPILOT_PX4
# MAV_TYPE of what may share a vehicle's ids without being one: ground station, onboard controller,
# gimbal, ADS-B, camera to Open Drone ID, battery to winch, illuminator, gripper, radio.
_NO_VEHICLE_TYPES = np.array([6, 18, 26, 27, *range(30, 35), *range(36, 43), 44, 48, 49])
_ANTENNA_TRACKER = 5  # MAV_TYPE_ANTENNA_TRACKER: it has an autopilot, and stands


def armed_at(
    offset: NDArray[np.int64],
    boot: NDArray[np.int32],
    heartbeats: Heartbeats,
    reports: ArmingReports,
    came: Arrivals | None = None,
) -> NDArray[np.int8]:
    """Whether the motors were armed at any time since the fix before, shape (n,), as ``Armed``.

    So a flight lasts from the first fix after they were reported armed to the first after disarmed.
    Fixes are in the order of time; one that came late into the log is placed with those that follow it.

    Args:
        offset: Where in the log the fixes are, shape (n,).
        boot: The boot of each fix (n,).
        heartbeats: All that came under the vehicle's ids.
        reports: What came under them of arming, which tells sooner than the heartbeats.
        came: When the vehicle's positions came, if some came late.
    """
    heartbeats = _of_autopilot(heartbeats)
    if came:
        shown, since = without_late(heartbeats.armed.view(np.uint8), heartbeats.offset, came)
        heartbeats = replace(heartbeats, armed=shown.view(np.bool_), offset=since)
    heartbeats = with_reports(heartbeats, reports)
    status = np.append(np.int8(Armed.UNKNOWN), heartbeats.armed.astype(np.int8))
    firsts = np.searchsorted(_in_log_order(offset), heartbeats.offset)  # far fewer than fixes
    armed = np.repeat(status, np.diff(firsts, prepend=0, append=len(offset)))
    _forget_earlier_boots(armed, boot, status, firsts)
    armed[1:] = np.where(boot[1:] == boot[:-1], np.maximum(armed[1:], armed[:-1]), armed[1:])
    return np.asarray(armed)


def modes_at(offset: NDArray[np.int64], heartbeats: Heartbeats, came: Arrivals | None) -> NDArray[np.int16]:
    """The flight mode at each fix (n,), by the heartbeat before it; -1 before the first.

    Args:
        offset: Where in the log the fixes are, shape (n,).
        heartbeats: All that came under the vehicle's ids.
        came: When the vehicle's positions came, if some came late.
    """
    heartbeats = _of_autopilot(heartbeats)
    mode, since = heartbeats.mode, heartbeats.offset
    if came:
        mode, since = without_late(mode, since, came)
    modes = np.append(np.int16(-1), mode.astype(np.int16))
    firsts = np.searchsorted(_in_log_order(offset), since, "right")  # far fewer than fixes
    return np.repeat(modes, np.diff(firsts, prepend=0, append=len(offset)))


def _in_log_order(offset: NDArray[np.int64]) -> NDArray[np.int64]:
    """Where fixes are in the log (n,), one that came late with those that follow it in time."""
    return np.asarray(np.minimum.accumulate(offset[::-1])[::-1])


def vehicle_kind(heartbeats: Heartbeats) -> VehicleKind:
    """Which kind of vehicle sent most heartbeats of those under its ids; nothing is known without any."""
    own = _of_autopilot(heartbeats)
    if not len(own):
        return VehicleKind()
    most = np.bincount(own.type).argmax()
    return kind_of(int(most), _AUTOPILOTS.get(int(own.autopilot[own.type == most][0])))


def moves_itself(heartbeats: Heartbeats) -> bool | None:
    """Whether what sent most heartbeats under some ids is a vehicle; None without any.

    Ground stations send where they are, too, as QGroundControl does for Follow Me, and antenna trackers.
    """
    if not len(heartbeats):
        return None
    own = _of_autopilot(heartbeats)
    return bool(len(own)) and int(np.bincount(own.type).argmax()) != _ANTENNA_TRACKER


def _of_autopilot(heartbeats: Heartbeats) -> Heartbeats:
    """The heartbeats that an autopilot sent: of the first kind in ``_AUTOPILOTS`` that there is, else all.

    Scripts that send heartbeats under the vehicle's ids name no autopilot, or the generic one.
    """
    is_vehicle = ~np.isin(heartbeats.type, _NO_VEHICLE_TYPES)
    kept = heartbeats.select((heartbeats.autopilot != _NO_AUTOPILOT) & is_vehicle)
    for autopilot in _AUTOPILOTS:
        own = kept.autopilot == autopilot
        if own.any():
            return kept.select(own)
    return kept


def _forget_earlier_boots(
    armed: NDArray[np.int8], boot: NDArray[np.int32], status: NDArray[np.int8], firsts: Indices
) -> None:
    """Take back the status "armed" of an earlier boot from fixes ahead of a boot's first heartbeat.

    A vehicle that boots is disarmed. Of equal heartbeats in a row only the first and last are known, so
    where the next one is "armed" too, nobody can tell that there was none in between.

    Args:
        armed: The status at each fix (n,), changed in place.
        boot: The boot of each fix (n,).
        status: "Unknown" and those of the heartbeats (m + 1,).
        firsts: The first fix after each heartbeat (m,).
    """
    starts = np.flatnonzero(np.diff(boot)) + 1
    last = np.searchsorted(firsts, starts, "right")
    following = np.append(status[1:], np.int8(Armed.UNKNOWN))[last]
    ends = np.append(firsts, len(armed))[last]
    old = (status[last] == Armed.YES) & (following != Armed.YES)
    n = len(armed)
    begun, ended = (np.bincount(at[old], minlength=n + 1)[:n] for at in (starts, ends))
    armed[np.cumsum(begun - ended) > 0] = Armed.UNKNOWN
