"""Places on the globe as ArduPilot carries them, and the local frame around the simulator's start."""

from __future__ import annotations

from dataclasses import dataclass

from flight_replay.geometry.flat_earth import FlatFrame

Metres = tuple[float, float, float]
"""North, east and up of the start."""


@dataclass(frozen=True, slots=True)
class Place:
    """Degrees times 1e7, and millimetres above mean sea level."""

    lat_e7: int
    lon_e7: int
    alt_mm: int


@dataclass(frozen=True, slots=True)
class Start:
    """Where the copter stands at boot: degrees, metres above mean sea level, and where it looks."""

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

    def place_of(self, position_m: Metres) -> Place:
        """The place that is so many metres north, east and up of the start."""
        north_m, east_m, up_m = position_m
        lat_deg, lon_deg = self.frame.to_degrees((north_m, east_m))
        return Place(
            round(float(lat_deg) * 1e7), round(float(lon_deg) * 1e7), round((self.alt_cm / 100 + up_m) * 1000)
        )

    def metres_of(self, lat_e7: int, lon_e7: int, alt_amsl_m: float) -> Metres:
        """Metres north, east and up of the start."""
        north_m, east_m = self.frame.to_metres(lat_e7 / 1e7, lon_e7 / 1e7)
        return float(north_m), float(east_m), alt_amsl_m - self.alt_cm / 100


@dataclass(frozen=True, slots=True)
class HomePlace:
    """Home: where RTL lands, and what relative altitudes count from."""

    lat_e7: int
    lon_e7: int
    alt_cm: int
    position_m: Metres
