"""Which positions of a ULog are read: the estimator's, global or local, else those of the GPS receiver."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats
from flight_replay.logs.ulog.ulog_file import Topic

_EARTH_RADIUS_M = 6_371_000.0
"""Of the sphere that PX4 projects with."""
_COVERED = 0.8
"""What covers less of the time than another source does is a leftover."""
_TINY = 1e-12


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class UlogPositions:
    """Positions as columns (n,), velocities north, east and up (n, 3); ``note`` says where they are from."""

    time_s: Floats
    lat_deg: Floats
    lon_deg: Floats
    amsl_m: Floats
    velocity_m_s: Floats
    heading_rad: Floats
    lacks_3d_fix: Flags
    note: str | None = None

    def __len__(self) -> int:
        return len(self.time_s)

    @property
    def usable_s(self) -> float:
        """From the first to the last position that the receiver had a fix for."""
        usable = self.time_s[~self.lacks_3d_fix]
        return float(usable[-1] - usable[0]) if len(usable) else 0.0


def positions_of(topics: Mapping[str, Topic]) -> UlogPositions | None:
    """The positions of the first source that covers most of the time; None if there is none at all."""
    sources = [
        _global(topics.get("vehicle_global_position")),
        _local(topics.get("vehicle_local_position")),
        _gps(topics.get("vehicle_gps_position")),
        _gps(topics.get("sensor_gps")),
    ]
    found = [source for source in sources if source is not None and len(source)]
    most_s = max((source.usable_s for source in found), default=0.0)
    return next((source for source in found if source.usable_s >= _COVERED * most_s), None)


def _global(topic: Topic | None) -> UlogPositions | None:
    if topic is None or "lat" not in topic or "lon" not in topic:
        return None
    if "lat_lon_valid" in topic:
        topic = topic.select(topic.get("lat_lon_valid") != 0)
    return UlogPositions(
        time_s=topic.time_s,
        lat_deg=topic.get("lat"),
        lon_deg=topic.get("lon"),
        amsl_m=topic.get("alt"),
        velocity_m_s=np.column_stack([topic.get("vel_n"), topic.get("vel_e"), -topic.get("vel_d")]),
        heading_rad=topic.get("yaw"),
        lacks_3d_fix=np.zeros(len(topic), np.bool_),
    )


def _local(topic: Topic | None) -> UlogPositions | None:
    """Places around a reference, where that is known."""
    if topic is None or "ref_lat" not in topic:
        return None
    ref_lat, ref_lon = topic.get("ref_lat"), topic.get("ref_lon")
    known = np.isfinite(ref_lat) & np.isfinite(ref_lon) & ((ref_lat != 0) | (ref_lon != 0))
    for flag in ("xy_global", "xy_valid"):
        if flag in topic:
            known &= topic.get(flag) != 0
    topic = topic.select(known)
    lat_deg, lon_deg = from_reference(
        topic.get("ref_lat"), topic.get("ref_lon"), topic.get("x"), topic.get("y")
    )
    amsl_m = topic.get("ref_alt") - topic.get("z")
    if "z_global" in topic:
        amsl_m = np.where(topic.get("z_global") != 0, amsl_m, np.nan)
    return UlogPositions(
        time_s=topic.time_s,
        lat_deg=lat_deg,
        lon_deg=lon_deg,
        amsl_m=amsl_m,
        velocity_m_s=np.column_stack([topic.get("vx"), topic.get("vy"), -topic.get("vz")]),
        heading_rad=topic.get("heading", "yaw"),
        lacks_3d_fix=np.zeros(len(topic), np.bool_),
        note="It has no vehicle_global_position: its positions are those of vehicle_local_position",
    )


def from_reference(
    lat_deg: Floats, lon_deg: Floats, north_m: Floats, east_m: Floats
) -> tuple[Floats, Floats]:
    """Latitude and longitude (n,) of places around references (n,), as PX4 projects them.

    The inverse of the azimuthal equidistant projection of a sphere: Snyder, Map Projections (USGS
    Professional Paper 1395), equations 20-14, 20-15 and 25-15.
    """
    lat, lon = np.radians(lat_deg), np.radians(lon_deg)
    distance_m = np.hypot(north_m, east_m)
    angle = distance_m / _EARTH_RADIUS_M
    share = np.sin(angle) / np.maximum(distance_m, _TINY)
    sine = np.cos(angle) * np.sin(lat) + north_m * share * np.cos(lat)
    across = np.cos(lat) * np.cos(angle) - north_m * share * np.sin(lat)
    turned = np.arctan2(east_m * share, across)
    lon_deg = np.degrees(lon + turned)
    return np.degrees(np.arcsin(np.clip(sine, -1.0, 1.0))), (lon_deg + 180.0) % 360.0 - 180.0


def _gps(topic: Topic | None) -> UlogPositions | None:
    """What a receiver says: in degrees and metres, or as integers before PX4 1.14."""
    if topic is None or not ("latitude_deg" in topic or "lat" in topic):
        return None
    is_new = "latitude_deg" in topic
    lat_deg, lon_deg, amsl_m = (
        (topic.get("latitude_deg"), topic.get("longitude_deg"), topic.get("altitude_msl_m"))
        if is_new
        else (topic.get("lat") / 1e7, topic.get("lon") / 1e7, topic.get("alt") / 1e3)
    )
    velocity = np.column_stack([topic.get("vel_n_m_s"), topic.get("vel_e_m_s"), -topic.get("vel_d_m_s")])
    if "vel_ned_valid" in topic:
        velocity[topic.get("vel_ned_valid") == 0] = np.nan
    positions = UlogPositions(
        time_s=topic.time_s,
        lat_deg=lat_deg,
        lon_deg=lon_deg,
        amsl_m=amsl_m,
        velocity_m_s=velocity,
        heading_rad=np.full(len(topic), np.nan),
        lacks_3d_fix=topic.get("fix_type") < 3,
        note="It has no position of the estimator: its positions are those of the GPS receiver",
    )
    return replace(positions, lacks_3d_fix=positions.lacks_3d_fix | ~np.isfinite(lat_deg))
