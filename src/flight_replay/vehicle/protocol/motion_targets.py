"""Sends targets that move, in the form that the vehicle's firmware takes.

Sources: ArduCopter's GCS_Mavlink.cpp (handle_message_set_position_target_local_ned, _global_int). Since
4.1 position, velocity and acceleration are taken together, but only in SET_POSITION_TARGET_LOCAL_NED, whose
origin is the EKF's and not home; before, the acceleration must be masked. 3.3 ignores the heading in it,
and takes it from CONDITION_YAW.
"""

from __future__ import annotations

from collections import deque
from math import hypot, radians
from statistics import median

from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.mavlink import Message, dialect
from flight_replay.supervisor.vehicle_interface import Target
from flight_replay.vehicle.link.vehicle_link import VehicleLink
from flight_replay.vehicle.protocol.commands import command_long

_IGNORE_VELOCITY, _IGNORE_ACCELERATION = 0b111 << 3, 0b111 << 6
_IGNORE_HEADING = (1 << 10) | (1 << 11)
TAKES_ACCELERATION = (4, 1)
"""The first version that follows position, velocity and acceleration together."""
_TAKES_HEADING = (3, 4)
_SAME_TIME_MS, _AT_REST_M_S = 5, 0.5
_KEPT = 15
_HEADING_EVERY = 2  # CONDITION_YAW at half the rate of targets.


class LocalOrigin:
    """Where the vehicle's local frame has its origin, from pairs of its global and local positions.

    It is kept from the first target on: whoever moves home in flight does not move what is followed.
    """

    def __init__(self) -> None:
        self._global: Message | None = None
        self._local: Message | None = None
        self._origins: deque[tuple[float, float, float]] = deque(maxlen=_KEPT)
        self._home_amsl_m = 0.0
        self._kept: tuple[FlatFrame, float] | None = None

    def receive(self, message: Message) -> None:
        """Process a message of the vehicle, on the link's thread."""
        kind = message.get_type()
        if kind == "GLOBAL_POSITION_INT":
            self._global = message
            self._home_amsl_m = (message.alt - message.relative_alt) / 1e3
        elif kind == "LOCAL_POSITION_NED":
            self._local = message
        else:
            return
        here, local = self._global, self._local
        if here is None or local is None or abs(here.time_boot_ms - local.time_boot_ms) > _SAME_TIME_MS:
            return
        if hypot(local.vx, local.vy, local.vz) < _AT_REST_M_S:
            lat_deg, lon_deg = FlatFrame(here.lat / 1e7, here.lon / 1e7).to_degrees((-local.x, -local.y))
            self._origins.append((float(lat_deg), float(lon_deg), here.alt / 1e3 + local.z))

    @property
    def known(self) -> bool:
        """Whether positions in the local frame can be given."""
        return bool(self._origins)

    def local_ned_m(self, lat_deg: float, lon_deg: float, alt_m: float) -> tuple[float, float, float]:
        """A place, at a height above home, as metres north, east and down of the origin."""
        if self._kept is None:
            # A copy: the link's thread adds to them.
            columns = zip(*tuple(self._origins), strict=True)
            origin_lat_deg, origin_lon_deg, origin_amsl_m = (median(column) for column in columns)
            self._kept = FlatFrame(origin_lat_deg, origin_lon_deg), origin_amsl_m - self._home_amsl_m
        frame, home_down_m = self._kept
        north_m, east_m = frame.to_metres(lat_deg, lon_deg).tolist()
        return north_m, east_m, home_down_m - alt_m


class MotionTargets:
    """Sends targets to one vehicle; ``origin`` has to receive its messages."""

    def __init__(self, link: VehicleLink, version: tuple[int, ...]) -> None:
        """``version`` is that of the firmware, such as (4, 6, 0), empty where unknown."""
        self._link, self._version = link, version
        self.origin = LocalOrigin()
        self._sent = 0

    def send_position(self, lat_deg: float, lon_deg: float, alt_m: float) -> None:
        """A place to fly to, at a height above home."""
        self._link.send(
            dialect.MAVLink_set_position_target_global_int_message(
                0, self._link.system, self._link.component,
                dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
                _IGNORE_VELOCITY | _IGNORE_ACCELERATION | _IGNORE_HEADING,
                round(lat_deg * 1e7), round(lon_deg * 1e7), alt_m, *(0.0,) * 8,
            )
        )  # fmt: skip

    def send(self, target: Target) -> None:
        """A target to follow until the next."""
        mask = 0 if self._version >= TAKES_ACCELERATION else _IGNORE_ACCELERATION
        heading_deg, rate_deg_s = target.heading_deg, target.heading_rate_deg_s
        if heading_deg is None or self._version < _TAKES_HEADING:
            mask |= _IGNORE_HEADING
        (north, east, up), (to_north, to_east, to_up) = target.velocity_m_s, target.acceleration_m_s2
        self._link.send(
            dialect.MAVLink_set_position_target_local_ned_message(
                0, self._link.system, self._link.component, dialect.MAV_FRAME_LOCAL_NED, mask,
                *self.origin.local_ned_m(target.lat_deg, target.lon_deg, target.alt_m),
                north, east, -up, to_north, to_east, -to_up,
                radians(heading_deg or 0.0), radians(rate_deg_s),
            )
        )  # fmt: skip
        if heading_deg is not None and self._version < _TAKES_HEADING and self._sent % _HEADING_EVERY == 0:
            self._link.send(command_long(self._link, dialect.MAV_CMD_CONDITION_YAW, heading_deg, 0, 0, 0))
        self._sent += 1
