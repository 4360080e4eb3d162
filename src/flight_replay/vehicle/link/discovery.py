"""Who is on the link, by their heartbeats: autopilots, and everything that only looks like one."""

from __future__ import annotations

import threading
from collections import Counter
from dataclasses import dataclass

from flight_replay.mavlink import Message, dialect
from flight_replay.vehicle.link.own_ids import OUR_SYSTEM

_NEIGHBOURS_S = 1.1  # Everybody's heartbeat comes once in it ...
_NEIGHBOURS_BEATS = 3  # ... or before the vehicle's third, where its clock runs fast.
_NO_VEHICLES = frozenset(
    {
        dialect.MAV_TYPE_GCS,
        dialect.MAV_TYPE_GIMBAL,
        dialect.MAV_TYPE_ADSB,
        dialect.MAV_TYPE_ANTENNA_TRACKER,
        dialect.MAV_TYPE_ONBOARD_CONTROLLER,
        dialect.MAV_TYPE_CAMERA,
        dialect.MAV_TYPE_ODID,
    }
)


@dataclass(frozen=True, slots=True, order=True)
class Sighting:
    """An autopilot that was heard."""

    system: int
    component: int
    vehicle_type: int
    autopilot: int


class Sightings:
    """Collects heartbeats, on the link's thread."""

    def __init__(self) -> None:
        """Nobody has been heard yet."""
        self._arrived = threading.Condition()
        self._seen: Counter[Sighting] = Counter()
        self._others: set[str] = set()

    def receive(self, message: Message) -> None:
        """Take in a message."""
        if message.get_type() != "HEARTBEAT" or message.get_srcSystem() == OUR_SYSTEM:
            return
        system, component = message.get_srcSystem(), message.get_srcComponent()
        with self._arrived:
            if message.type in _NO_VEHICLES or message.autopilot == dialect.MAV_AUTOPILOT_INVALID:
                self._others.add(f"{system}/{component}")
                return
            self._seen[Sighting(system, component, message.type, message.autopilot)] += 1
            self._arrived.notify_all()

    def wait(self, limit_s: float) -> Sighting | None:
        """The autopilot with the lowest system id, once its neighbours had time to be heard too."""
        with self._arrived:
            if not self._arrived.wait_for(lambda: bool(self._seen), limit_s):
                return None
            self._arrived.wait_for(lambda: max(self._seen.values()) >= _NEIGHBOURS_BEATS, _NEIGHBOURS_S)
        return min(self.vehicles)

    @property
    def vehicles(self) -> list[Sighting]:
        """All autopilots heard."""
        with self._arrived:
            return sorted(self._seen)

    @property
    def others(self) -> list[str]:
        """Who else was heard, as system/component."""
        with self._arrived:
            return sorted(self._others)
