"""Finds the vehicles on a link by their heartbeats, among gimbals, ground stations and the like."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from flight_replay.mavlink import Message, dialect, source_of
from flight_replay.vehicle.link.own_ids import OUR_SYSTEM

_OTHERS_S = 1.1  # Every system sends a heartbeat within this time ...
_OTHERS_HEARTBEATS = 3  # ... or before the third of the first vehicle, if its clock runs fast.
_NOT_VEHICLES = frozenset(
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
class DiscoveredVehicle:
    """A vehicle that sends heartbeats; ``vehicle_type`` is a MAV_TYPE, ``autopilot`` a MAV_AUTOPILOT."""

    system: int
    component: int
    vehicle_type: int
    autopilot: int


class VehicleDiscovery:
    """Collects heartbeats, on the link's thread."""

    def __init__(self, check_link: Callable[[], None] = lambda: None) -> None:
        """``check_link`` raises an error where none can come."""
        self._check_link = check_link
        self._changed = threading.Condition()
        self._heartbeats: Counter[DiscoveredVehicle] = Counter()
        self._others: set[str] = set()

    def receive(self, message: Message) -> None:
        """Process a message."""
        if message.get_type() != "HEARTBEAT" or message.get_srcSystem() == OUR_SYSTEM:
            return
        system, component = source_of(message)
        with self._changed:
            if message.type in _NOT_VEHICLES or message.autopilot == dialect.MAV_AUTOPILOT_INVALID:
                self._others.add(f"{system}/{component}")
                return
            self._heartbeats[DiscoveredVehicle(system, component, message.type, message.autopilot)] += 1
            self._changed.notify_all()

    def wait(self, limit_s: float) -> DiscoveredVehicle | None:
        """The vehicle with the lowest system id, after each could send a heartbeat; None if there is none."""
        with self._changed:
            if not self._changed.wait_for(lambda: bool(self._heartbeats), limit_s):
                self._check_link()
                return None
            self._changed.wait_for(lambda: max(self._heartbeats.values()) >= _OTHERS_HEARTBEATS, _OTHERS_S)
        return min(self.vehicles)

    @property
    def vehicles(self) -> list[DiscoveredVehicle]:
        """All vehicles so far, by system id."""
        with self._changed:
            return sorted(self._heartbeats)

    @property
    def others(self) -> list[str]:
        """Senders of heartbeats that are not vehicles, as system/component."""
        with self._changed:
            return sorted(self._others)
