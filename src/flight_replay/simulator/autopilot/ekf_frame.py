"""The EKF's local frame: its origin where the copter was booted, home, and positions in it."""

from __future__ import annotations

from flight_replay.simulator.autopilot.location import HomeLocation, Start
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.mission.local_items import LocalItem, copter_command, is_navigation
from flight_replay.simulator.mission.stored_items import ALTITUDE_LIMIT_M, StoredItem

# MAV_FRAMEs.
_ABSOLUTE_FRAMES = frozenset({0, 5})
# Heights above home, and above terrain, which is level here.
_RELATIVE_FRAMES = frozenset({3, 6, 10, 11})
_STORED_ABSOLUTE, _STORED_TERRAIN = 0, 10
_WAYPOINT = 16


class EkfFrame:
    """Metres north, east and up of ``start``, the EKF's origin; home may be elsewhere."""

    def __init__(self, start: Start) -> None:
        self.start = start
        self.home: HomeLocation | None = None

    def set_home(self, position_m: Vector) -> None:
        """Make a position home."""
        location = self.start.location_of(position_m)
        self.home = HomeLocation(location.lat_e7, location.lon_e7, round(location.alt_mm / 10), position_m)

    @property
    def home_item(self) -> StoredItem:
        """Home as mission item 0."""
        home = self.home
        if home is None:
            return StoredItem(_WAYPOINT)
        return StoredItem(_WAYPOINT, lat_e7=home.lat_e7, lon_e7=home.lon_e7, alt_cm=home.alt_cm)

    def position_of(self, lat_e7: int, lon_e7: int, alt_m: float, mav_frame: int) -> Vector | None:
        """The position of a location, its altitude above sea level or home by MAV_FRAME; None if invalid."""
        if abs(lat_e7) > 90 * 10**7 or abs(lon_e7) > 180 * 10**7 or not abs(alt_m) < ALTITUDE_LIMIT_M:
            return None
        if mav_frame in _ABSOLUTE_FRAMES:
            return self.start.position_of(lat_e7, lon_e7, alt_m)
        if mav_frame not in _RELATIVE_FRAMES or self.home is None:
            return None
        return self.start.position_of(lat_e7, lon_e7, alt_m + self.home.alt_cm / 100)

    def local_item(self, seq: int, item: StoredItem, around_m: Vector) -> LocalItem:
        """A mission item in metres around ``around_m``, a position in this frame."""
        north_east_m = self._north_east_m(item, around_m) if item.lat_e7 or item.lon_e7 else None
        up_m: float | None = item.alt_m + (self._ground_m(item) - around_m[2])
        if item.alt_cm == 0 and is_navigation(item.command):
            up_m = None
        above_terrain = item.frame == _STORED_TERRAIN
        return LocalItem(seq, copter_command(item.command), item.params, north_east_m, up_m, above_terrain)

    def _north_east_m(self, item: StoredItem, around_m: Vector) -> tuple[float, float]:
        north_m, east_m, _ = self.start.position_of(item.lat_e7, item.lon_e7, 0.0)
        return north_m - around_m[0], east_m - around_m[1]

    def _ground_m(self, item: StoredItem) -> float:
        """What the item's altitude counts from: the sea, or home."""
        if self.home is None:
            return 0.0
        return -self.start.alt_cm / 100 if item.frame == _STORED_ABSOLUTE else self.home.position_m[2]
