"""Reads a ULog of PX4: positions, velocities, heading, arming and heights by the rules of docs/logs.md."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flight_replay.exceptions import LogError
from flight_replay.geometry.arrays import Floats
from flight_replay.logs.byte_source import OpenLog, Progress
from flight_replay.logs.derived_velocity import with_derived_velocity
from flight_replay.logs.heights_above_home import with_heights_above_home
from flight_replay.logs.recording import Recording
from flight_replay.logs.track import Armed, Track, track_from_columns
from flight_replay.logs.ulog.ulog_file import Topic, UlogTopics, read_topics
from flight_replay.logs.ulog.ulog_positions import UlogPositions, positions_of
from flight_replay.logs.ulog.ulog_vehicle import kind_of_ulog
from flight_replay.logs.usable_fixes import usable_fixes
from flight_replay.logs.vehicles import VehicleId

_ARMED_STATE = 2
"""ARMING_STATE_ARMED of PX4's VehicleStatus, in all versions."""
_NEAR_S = 0.25
"""Velocities and headings come at 10 Hz or more."""
_LONGEST_DROPOUT_S = 1.0
_TOPICS = (
    "vehicle_global_position",
    "vehicle_local_position",
    "vehicle_gps_position",
    "sensor_gps",
    "home_position",
    "vehicle_status",
    "actuator_armed",
    "vehicle_land_detected",
)
_NO_SAMPLES = Topic(np.zeros(0), {})


def read_ulog(log: OpenLog, _vehicle: VehicleId | None, progress: Progress | None) -> Recording:
    """Read the vehicle's fixes; see ``log_formats.Read``."""
    read = read_topics(log, _TOPICS, progress)
    positions = positions_of(read.topics)
    if positions is None:
        raise LogError(
            f"{log.name} is a ULog without any position (no global, local or GPS position of PX4 in it); "
            "name a log of a flight outdoors"
        )
    usable = usable_fixes(_track(read, positions), positions.lacks_3d_fix)
    if not len(usable.track):
        raise LogError(f"{log.name} has no usable position: {usable.why_none()}; name another log")
    track = with_heights_above_home(with_derived_velocity(usable.track))
    kind = kind_of_ulog(read)
    return Recording(
        path=log.name,
        bytes=read.bytes,
        track=track,
        without_position=usable.without_position,
        rejected=usable.rejected,
        firmware=kind.firmware,
        vehicle_type=kind.name,
        is_multicopter=kind.is_multicopter,
        start_utc_s=_start_utc_s(read, float(track.time_s[0])),
        notes=_notes(read, positions, track),
    )


def _track(read: UlogTopics, positions: UlogPositions) -> Track:
    """All positions with what other topics say at their times."""
    time_s = positions.time_s
    local = read.topics.get("vehicle_local_position", _NO_SAMPLES)
    velocity = np.column_stack([local.get("vx"), local.get("vy"), -local.get("vz")])
    if "v_xy_valid" in local:
        velocity[local.get("v_xy_valid") == 0] = np.nan
    velocity = _nearest(local, velocity, time_s)
    velocity = np.where(np.isfinite(velocity), velocity, positions.velocity_m_s)
    heading = _nearest(local, local.get("heading", "yaw")[:, None], time_s)[:, 0]
    heading = np.where(np.isfinite(heading), heading, positions.heading_rad)
    home_m = _held(*_home_amsl_m(read), time_s)
    return track_from_columns(
        time_s,
        positions.lat_deg,
        positions.lon_deg,
        positions.amsl_m - home_m,
        amsl_m=positions.amsl_m,
        velocity_m_s=velocity,
        heading_deg=np.degrees(heading) % 360.0,
        armed=_armed(read, time_s),
    )


def _nearest(topic: Topic, values: Floats, time_s: Floats) -> Floats:
    """Values (m, d) of a topic's samples (n, d) nearest to times (m,), not a number where none is near."""
    if not len(topic):
        return np.full((len(time_s), values.shape[1]), np.nan)
    behind = np.minimum(np.searchsorted(topic.time_s, time_s), len(topic) - 1)
    before = np.maximum(behind - 1, 0)
    is_before = np.abs(topic.time_s[before] - time_s) <= np.abs(topic.time_s[behind] - time_s)
    nearest = np.where(is_before, before, behind)
    is_near = np.abs(topic.time_s[nearest] - time_s) <= _NEAR_S
    return np.where(is_near[:, None], values[nearest], np.nan)


def _held(since_s: Floats, values: Floats, time_s: Floats) -> Floats:
    """Values (m,) at times (m,) that hold from times (n,) on; the first one before, too."""
    if not len(since_s):
        return np.full(len(time_s), np.nan)
    return np.asarray(values[np.maximum(np.searchsorted(since_s, time_s, side="right") - 1, 0)])


def _home_amsl_m(read: UlogTopics) -> tuple[Floats, Floats]:
    """Home's altitudes above the sea, and since when each holds."""
    home = read.topics.get("home_position", _NO_SAMPLES)
    amsl_m = home.get("alt")
    known = np.isfinite(amsl_m)
    if "valid_alt" in home:
        known &= home.get("valid_alt") != 0
    return home.time_s[known], amsl_m[known]


def _armed(read: UlogTopics, time_s: Floats) -> NDArray[np.int8]:
    """``Armed`` values at times (n,)."""
    status, actuators = (read.topics.get(name, _NO_SAMPLES) for name in ("vehicle_status", "actuator_armed"))
    if len(status) and "arming_state" in status:
        armed = _held(status.time_s, status.get("arming_state") == _ARMED_STATE, time_s)
    elif len(actuators) and "armed" in actuators:
        armed = _held(actuators.time_s, actuators.get("armed") != 0, time_s)
    else:
        return np.full(len(time_s), Armed.UNKNOWN, np.int8)
    return np.where(armed, Armed.YES, Armed.NO).astype(np.int8)


def _start_utc_s(read: UlogTopics, start_s: float) -> float | None:
    """The Unix time of a time since boot, by what the GPS said."""
    for name in ("vehicle_gps_position", "sensor_gps"):
        gps = read.topics.get(name, _NO_SAMPLES)
        known = gps.select(gps.get("time_utc_usec") > 1e15)  # Before 2001 it was not set.
        if len(known):
            return start_s + float(np.median(known.get("time_utc_usec") / 1e6 - known.time_s))
    return None


def _notes(read: UlogTopics, positions: UlogPositions, track: Track) -> tuple[str, ...]:
    """What a person should know about how the log was read."""
    notes = [] if positions.note is None else [positions.note]
    if read.is_damaged:
        notes.append("Parts of the log are damaged; the rest is read")
    if read.dropouts_s > _LONGEST_DROPOUT_S:
        notes.append(f"The logger lost {read.dropouts_s:.1f} s in all")
    landed = read.topics.get("vehicle_land_detected", _NO_SAMPLES)
    armed_s = track.time_s[track.armed == Armed.YES]
    if len(landed) and "landed" in landed and len(armed_s):
        is_landed = _held(landed.time_s, landed.get("landed"), armed_s)
        if (is_landed != 0).all():
            notes.append("PX4 says that the vehicle was armed, but never took off")
    return tuple(notes)
