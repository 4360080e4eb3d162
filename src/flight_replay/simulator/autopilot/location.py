"""Locations as ArduPilot stores them, and the local frame around the point where the copter was booted."""

from __future__ import annotations

from dataclasses import dataclass

from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.simulator.dynamics.vector import Vector


@dataclass(frozen=True, slots=True)
class Location:
    """Degrees times 1e7, and millimetres above mean sea level."""

    lat_e7: int
    lon_e7: int
    alt_mm: int


@dataclass(frozen=True, slots=True)
class Start:
    """Where the copter stands at boot: degrees, metres above mean sea level, and its heading.

    Positions in metres are north, east and up of here.
    """

    lat_deg: float
    lon_deg: float
    alt_amsl_m: float = 0.0
    heading_deg: float = 0.0

    @property
    def lat_e7(self) -> int:
        """Latitude, degrees times 1e7."""
        return round(self.lat_deg * 1e7)

    @property
    def lon_e7(self) -> int:
        """Longitude, degrees times 1e7."""
        return round(self.lon_deg * 1e7)

    @property
    def alt_cm(self) -> int:
        """Height above mean sea level."""
        return round(self.alt_amsl_m * 100)

    @property
    def frame(self) -> FlatFrame:
        """ArduPilot's metres around the start."""
        return FlatFrame(self.lat_e7 / 1e7, self.lon_e7 / 1e7)

    def location_of(self, position_m: Vector) -> Location:
        """The location of a position."""
        north_m, east_m, up_m = position_m
        lat_deg, lon_deg = self.frame.to_degrees((north_m, east_m))
        return Location(
            round(float(lat_deg) * 1e7), round(float(lon_deg) * 1e7), round((self.alt_cm / 100 + up_m) * 1000)
        )

    def position_of(self, lat_e7: int, lon_e7: int, alt_amsl_m: float) -> Vector:
        """The position of a location."""
        north_m, east_m = self.frame.to_metres(lat_e7 / 1e7, lon_e7 / 1e7)
        return float(north_m), float(east_m), alt_amsl_m - self.alt_cm / 100


@dataclass(frozen=True, slots=True)
class HomeLocation:
    """Home: where RTL lands, and what relative altitudes count from."""

    lat_e7: int
    lon_e7: int
    alt_cm: int
    position_m: Vector
