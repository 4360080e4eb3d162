"""Which vehicle is on the link, and what it can do: as it reports, not derived from its version."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf

from flight_replay.events import Listener, Phase, Waiting, ignore
from flight_replay.exceptions import VehicleError
from flight_replay.logs.vehicle_kinds import MULTICOPTERS
from flight_replay.mavlink import Message, dialect
from flight_replay.vehicle.link import timesync
from flight_replay.vehicle.link.discovery import DiscoveredVehicle, VehicleDiscovery
from flight_replay.vehicle.link.own_ids import OUR_SYSTEM
from flight_replay.vehicle.link.vehicle_link import VehicleLink
from flight_replay.vehicle.protocol.commands import command_long
from flight_replay.vehicle.protocol.parameters import read_parameters

_VERSION_S = 8.0
_SAY_EVERY_S = 5.0
_BUILTIN = b"builtin\0"
"""What the built-in copter sends where ArduPilot has the hash of its source code."""
_REQUEST_CAPABILITIES = 520  # MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, which 3.3 knows too.

_SIMULATOR_PARAMETERS = ("SIM_SPEEDUP", "SIM_WIND_SPD")
FENCE_PARAMETERS = (
    "FENCE_ENABLE", "FENCE_AUTOENABLE", "FENCE_TYPE",
    "FENCE_ALT_MAX", "FENCE_ALT_MIN", "FENCE_RADIUS", "FENCE_MARGIN", "FENCE_TOTAL",
)  # fmt: skip
"""Metres; 3.3 has no FENCE_ALT_MIN and FENCE_TOTAL, and FENCE_AUTOENABLE exists since 4.6."""
RTL_END_PARAMETERS = ("RTL_ALT_FINAL", "RTL_ALT_FINAL_M")
"""Where RTL ends, 0 on the ground: cm, or in 4.7 metres."""
_RTL_LOITER, _USUAL_RTL_LOITER_MS = "RTL_LOIT_TIME", 5000.0
_RALLY_POINTS, _RALLY_LIMIT_KM = "RALLY_TOTAL", "RALLY_LIMIT_KM"
_GCS_FAILSAFE, _FAILSAFE_OPTIONS = "FS_GCS_ENABLE", "FS_OPTIONS"
_OR_AUTO_GOES_ON = 2
"""Of ``FS_GCS_ENABLE`` before 4.0; since then it is a bit of ``FS_OPTIONS``."""
_GCS_SYSTEMS, _LAST_GCS_SYSTEM = ("SYSID_MYGCS", "MAV_GCS_SYSID"), "MAV_GCS_SYSID_HI"
"""Whose heartbeats the failsafe counts, up to 4.6 and in 4.7, where it may be all up to a last one, or 0."""
_CHECKED_PARAMETERS = (
    *FENCE_PARAMETERS, *RTL_END_PARAMETERS, _RTL_LOITER, _RALLY_POINTS, _RALLY_LIMIT_KM,
    _GCS_FAILSAFE, _FAILSAFE_OPTIONS, *_GCS_SYSTEMS, _LAST_GCS_SYSTEM,
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Identity:
    """A vehicle: ``vehicle_type`` is a MAV_TYPE, ``autopilot`` a MAV_AUTOPILOT, ``version`` "4.6.0" or "".

    ``serves_fence`` is whether it tells its fence by the mission protocol. ``builtin`` is this program's own
    copter, whose version is that of the firmware that it flies as.
    """

    system: int
    vehicle_type: int
    autopilot: int
    version: str
    takes_item_int: bool
    simulated: bool
    serves_fence: bool = False
    builtin: bool = False
    maturity: int = 0
    """What FIRMWARE_VERSION_TYPE is: 0 in development, 64 alpha, 128 beta, 192 candidate, 255 official."""
    parameters: Mapping[str, float] = field(default_factory=dict)

    @property
    def version_numbers(self) -> tuple[int, ...]:
        """The version as numbers, such as (4, 6, 0); empty where it is unknown."""
        return tuple(int(part) for part in self.version.split(".") if part)

    @property
    def rtl_loiter_s(self) -> float:
        """How long RTL waits over home before it lands."""
        return self.parameters.get(_RTL_LOITER, _USUAL_RTL_LOITER_MS) / 1000.0

    @property
    def rally_limit_m(self) -> float:
        """How far away rally points may be that RTL goes to, infinite without a limit, 0 without any."""
        if not self.parameters.get(_RALLY_POINTS):
            return 0.0
        limit_km = self.parameters.get(_RALLY_LIMIT_KM, 0.0)
        return limit_km * 1000.0 if limit_km > 0 else inf

    def without_failsafe(self, mode: str) -> str:
        """Why no failsafe acts when the link is lost in a mode; empty where one does, or it is unknown."""
        enabled = self.parameters.get(_GCS_FAILSAFE, 1.0)
        options = self.parameters.get(_FAILSAFE_OPTIONS, 0.0)
        if enabled == 0 or (enabled == _OR_AUTO_GOES_ON and mode == "AUTO"):
            return f"{_GCS_FAILSAFE} is {enabled:.0f}"
        if int(options) & _OR_AUTO_GOES_ON and mode == "AUTO":
            return f"{_FAILSAFE_OPTIONS} is {options:.0f}: AUTO goes on"
        last = self.parameters.get(_LAST_GCS_SYSTEM, 0.0)
        for name in _GCS_SYSTEMS:
            first = self.parameters.get(name, OUR_SYSTEM)
            if not first <= OUR_SYSTEM <= max(first, last):
                return f"{name} is {first:.0f}, not {OUR_SYSTEM}"
        return ""

    @property
    def is_multicopter(self) -> bool:
        """Whether it is a multicopter with ArduPilot."""
        return self.vehicle_type in MULTICOPTERS and self.is_ardupilot

    @property
    def is_ardupilot(self) -> bool:
        """Whether the autopilot is ArduPilot."""
        return self.autopilot == int(dialect.MAV_AUTOPILOT_ARDUPILOTMEGA)

    @property
    def kind(self) -> str:
        """The vehicle type as a word, such as quadcopter."""
        entry = dialect.enums["MAV_TYPE"].get(self.vehicle_type)
        name = entry.name.removeprefix("MAV_TYPE_").replace("_", " ").lower() if entry else "vehicle"
        return MULTICOPTERS.get(self.vehicle_type, name)

    @property
    def name(self) -> str:
        """Firmware, version, type and system id, for messages."""
        firmware = (
            "ArduCopter" if self.is_multicopter else "ArduPilot" if self.is_ardupilot else "unknown firmware"
        )
        if self.builtin and self.is_multicopter:
            release = ".".join(map(str, self.version_numbers[:2]))
            return f"built-in copter, flies as {firmware} {release} (system {self.system})"
        what = f"{firmware} {self.version}".strip()
        return f"{what} ({'simulated ' if self.simulated else ''}{self.kind}, system {self.system})"


def find_vehicle(
    discovery: VehicleDiscovery, link_name: str, hint: str, limit_s: float, listener: Listener = ignore
) -> DiscoveredVehicle:
    """The vehicle on the link: of several, the one with the lowest system id.

    Args:
        discovery: Collects the heartbeats on the link.
        link_name: The connection string.
        hint: What to check if nobody is heard.
        limit_s: Seconds to wait, possibly without end.
        listener: Told every few seconds that there is none yet.

    Raises:
        VehicleError: No vehicle sends a heartbeat in time.
    """
    waited_s = 0.0
    while waited_s < limit_s:
        step_s = min(_SAY_EVERY_S, limit_s - waited_s)
        vehicle = discovery.wait(step_s)
        if vehicle is not None:
            return vehicle
        waited_s += step_s
        listener(Waiting(Phase.CONNECT, f"no heartbeat of a vehicle for {waited_s:.0f} s"))
    others = ", ".join(discovery.others)
    only = f", only from system/component {others}" if others else ""
    raise VehicleError(f"no heartbeat of a vehicle on {link_name} in {limit_s:.0f} s{only}; {hint}")


def identify(link: VehicleLink, vehicle: DiscoveredVehicle) -> Identity:
    """What a vehicle is and can do, from its heartbeat, AUTOPILOT_VERSION and parameters."""
    version = _request_version(link)
    parameters = read_parameters(link, [*_SIMULATOR_PARAMETERS, *_CHECKED_PARAMETERS])
    capabilities = version.capabilities if version else 0
    return Identity(
        system=vehicle.system,
        vehicle_type=vehicle.vehicle_type,
        autopilot=vehicle.autopilot,
        version=_version(version.flight_sw_version) if version else "",
        takes_item_int=bool(capabilities & dialect.MAV_PROTOCOL_CAPABILITY_MISSION_INT),
        simulated=any(name in parameters for name in _SIMULATOR_PARAMETERS),
        serves_fence=bool(capabilities & dialect.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE),
        builtin=version is not None and bytes(version.flight_custom_version) == _BUILTIN,
        maturity=version.flight_sw_version & 0xFF if version else 0,
        parameters={name: parameters[name] for name in _CHECKED_PARAMETERS if name in parameters},
    )


def _request_version(link: VehicleLink) -> Message | None:
    """AUTOPILOT_VERSION, or None from a vehicle that does not send it; also measures the round trip."""
    first_s = link.now_s()
    with link.inbox("AUTOPILOT_VERSION") as inbox:
        while (requested_s := link.now_s()) < first_s + _VERSION_S:
            timesync.ping(link)
            link.send(command_long(link, _REQUEST_CAPABILITIES, 1))
            retry_at_s = requested_s + link.round_trip.retry_s
            if (message := inbox.get(retry_at_s - link.now_s())) is not None:
                if requested_s == first_s:  # A later answer may be to any of the requests.
                    link.round_trip.estimated(link.now_s() - requested_s)
                return message
    return None


def _version(packed: int) -> str:
    """Major, minor and patch, from the highest byte (AP_FWVersion)."""
    return ".".join(str(packed >> shift & 0xFF) for shift in (24, 16, 8))
