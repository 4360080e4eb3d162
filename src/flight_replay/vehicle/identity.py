"""Which vehicle is on the link, and what it is: asked of the vehicle, not guessed from its version."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from flight_replay.errors import VehicleError
from flight_replay.mavlink import Message, dialect
from flight_replay.vehicle.link import timesync
from flight_replay.vehicle.link.discovery import Sighting, Sightings
from flight_replay.vehicle.link.port import Port
from flight_replay.vehicle.protocol.commands import command
from flight_replay.vehicle.protocol.parameters import read_parameters

_VERSION_S = 8.0
_REQUEST_CAPABILITIES = 520  # MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, which 3.3 knows too.

_MULTICOPTERS = {
    dialect.MAV_TYPE_QUADROTOR: "quadcopter",
    dialect.MAV_TYPE_TRICOPTER: "tricopter",
    dialect.MAV_TYPE_HEXAROTOR: "hexacopter",
    dialect.MAV_TYPE_OCTOROTOR: "octocopter",
    dialect.MAV_TYPE_DODECAROTOR: "dodecacopter",
    dialect.MAV_TYPE_DECAROTOR: "decacopter",
}
_SIMULATION = ("SIM_SPEEDUP", "SIM_WIND_SPD")
FENCE = (
    "FENCE_ENABLE", "FENCE_AUTOENABLE", "FENCE_TYPE",
    "FENCE_ALT_MAX", "FENCE_ALT_MIN", "FENCE_RADIUS", "FENCE_MARGIN",
)  # fmt: skip
"""Parameters of the fence, metres; 3.3 has no lower limit, and none before 4.6 switches it on by itself."""


@dataclass(frozen=True, slots=True)
class Identity:
    """A vehicle: ``vehicle_type`` is a MAV_TYPE, ``autopilot`` a MAV_AUTOPILOT, ``version`` "4.6.0" or ""."""

    system: int
    component: int
    vehicle_type: int
    autopilot: int
    version: str
    takes_item_int: bool
    simulated: bool
    parameters: Mapping[str, float] = field(default_factory=dict)

    @property
    def is_multicopter(self) -> bool:
        """Whether it flies by its rotors alone, and ArduPilot flies it."""
        return self.vehicle_type in _MULTICOPTERS and self.is_ardupilot

    @property
    def is_ardupilot(self) -> bool:
        """Whether the autopilot is ArduPilot."""
        return self.autopilot == int(dialect.MAV_AUTOPILOT_ARDUPILOTMEGA)

    @property
    def kind(self) -> str:
        """A word for what it is."""
        entry = dialect.enums["MAV_TYPE"].get(self.vehicle_type)
        name = entry.name.removeprefix("MAV_TYPE_").replace("_", " ").lower() if entry else "vehicle"
        return _MULTICOPTERS.get(self.vehicle_type, name)

    @property
    def name(self) -> str:
        """Firmware, version and kind in one phrase."""
        firmware = (
            "ArduCopter" if self.is_multicopter else "ArduPilot" if self.is_ardupilot else "unknown firmware"
        )
        what = f"{firmware} {self.version}".strip()
        return f"{what} ({'simulated ' if self.simulated else ''}{self.kind}, system {self.system})"


def find_vehicle(sightings: Sightings, connection_string: str, limit_s: float) -> Sighting:
    """The vehicle on the link: of several, the one with the lowest system id.

    Raises:
        VehicleError: No autopilot is heard in time.
    """
    first = sightings.wait(limit_s)
    if first is None:
        others = sightings.others
        heard = f" (only {', '.join(others)})" if others else ""
        raise VehicleError(
            f"no vehicle is heard on {connection_string} within {limit_s:.0f} s{heard}; "
            "check the connection string, the baud rate and the vehicle's power"
        )
    return first


def identify(port: Port, sighting: Sighting) -> Identity:
    """What the vehicle says of itself."""
    version = _ask_version(port)
    parameters = read_parameters(port, [*_SIMULATION, *FENCE])
    capabilities = version.capabilities if version else 0
    return Identity(
        system=sighting.system,
        component=sighting.component,
        vehicle_type=sighting.vehicle_type,
        autopilot=sighting.autopilot,
        version=_version(version.flight_sw_version) if version else "",
        takes_item_int=bool(capabilities & dialect.MAV_PROTOCOL_CAPABILITY_MISSION_INT),
        simulated=any(name in parameters for name in _SIMULATION),
        parameters={name: parameters[name] for name in FENCE if name in parameters},
    )


def _ask_version(port: Port) -> Message | None:
    """AUTOPILOT_VERSION, or None from a vehicle that never tells it; on the way, learn the round trip."""
    first_s = port.now_s()
    with port.inbox("AUTOPILOT_VERSION", timesync.KIND) as inbox:
        while (asked_s := port.now_s()) < first_s + _VERSION_S:
            timesync.ping(port)
            port.send(command(port, _REQUEST_CAPABILITIES, 1))
            again_s = asked_s + port.trip.again_s
            while (message := inbox.get(again_s - port.now_s())) is not None:
                if not timesync.learn(port, message):
                    if asked_s == first_s:  # A later answer may be to any of the requests.
                        port.trip.guess(port.now_s() - asked_s)
                    return message
    return None


def _version(packed: int) -> str:
    """Three bytes of version, from the highest (AP_FWVersion)."""
    return ".".join(str(packed >> shift & 0xFF) for shift in (24, 16, 8))
