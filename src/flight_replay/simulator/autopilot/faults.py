"""What can be wrong with the simulated vehicle, as plain data for tests and rehearsals.

``Faults()`` is a sound ArduCopter 4.6. Each field makes one thing different; ``happenings`` are
things that befall the flight at a moment of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from flight_replay.simulator.autopilot.parameter_table import Parameters
from flight_replay.simulator.mission.store import CAPACITY


@dataclass(frozen=True, slots=True)
class MissionFaults:
    """How the mission protocol errs: results are MAV_MISSION_RESULT values.

    ``result_of_item`` answers the item of that sequence number instead of storing it,
    ``result_of_upload`` the whole upload after its last item.
    """

    knows_item_int: bool = True
    capacity: int = CAPACITY
    result_of_item: Mapping[int, int] = field(default_factory=dict)
    result_of_upload: int = 0


@dataclass(frozen=True, slots=True)
class OtherHeartbeat:
    """A heartbeat that somebody else sends over the same link, once a second.

    With a ``place`` (degrees times 1e7, millimetres above home) it says where it is as well.
    """

    system: int
    component: int
    vehicle_type: int
    autopilot: int = 8
    base_mode: int = 0
    custom_mode: int = 0
    system_status: int = 4
    place: tuple[int, int, int] | None = None

    @property
    def fields(self) -> tuple[int, int, int, int, int]:
        """What HEARTBEAT carries, in its order."""
        return self.vehicle_type, self.autopilot, self.base_mode, self.custom_mode, self.system_status


GIMBAL = OtherHeartbeat(1, 154, 26)
RADIO = OtherHeartbeat(51, 68, 0)
ADSB_RECEIVER = OtherHeartbeat(1, 156, 27)
SECOND_COPTER = OtherHeartbeat(
    2, 1, 2, autopilot=3, base_mode=209, custom_mode=5, place=(473900000, 85400000, 77000)
)


# MAV_PROTOCOL_CAPABILITY: MISSION_FLOAT, PARAM_FLOAT, MISSION_INT, COMMAND_INT,
# SET_POSITION_TARGET_LOCAL_NED and _GLOBAL_INT, MAVLINK2. ArduCopter has more (files, fences).
_CAPABILITIES = 1 | 2 | 4 | 8 | 128 | 256 | 8192


@dataclass(frozen=True, slots=True)
class Personality:
    """Which vehicle and firmware it is: ``vehicle_type`` is a MAV_TYPE."""

    vehicle_type: int = 2
    firmware: str = "ArduCopter"
    version: tuple[int, int, int] = (4, 6, 0)
    mavlink1: bool = False
    unknown_commands: frozenset[int] = frozenset()
    """Numbers of commands that this copter knows and that firmware does not."""
    answers_set_mode: bool = False
    """Whether SET_MODE, a message, is answered with a COMMAND_ACK of its message number."""
    auto_needs_takeoff: bool = True
    """Whether AUTO is refused on the ground without a take-off item."""
    arming_takes_s: float = 0.0
    capabilities: int = _CAPABILITIES
    parameters: Mapping[str, float] = field(default_factory=dict)
    """Defaults that differ from those of 4.6."""
    renamed_parameters: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    """New names and factors to new units, by 4.6 name."""

    def table(self, values: Mapping[str, float] | None = None) -> Parameters:
        """The parameters of this vehicle, some changed; KeyError for names that it does not have."""
        return Parameters({**self.parameters, **(values or {})}, self.renamed_parameters)

    @property
    def banner(self) -> str:
        """The firmware's name and version, as its first status text gives it."""
        return f"{self.firmware} V{'.'.join(str(part) for part in self.version)}"


PLANE = Personality(vehicle_type=1, firmware="ArduPlane")
ROVER = Personality(vehicle_type=10, firmware="ArduRover")
COPTER_3_3 = Personality(
    version=(3, 3, 0),
    mavlink1=True,
    unknown_commands=frozenset({176, 510, 511, 512, 401, 224, 42428}),
    answers_set_mode=True,
    auto_needs_takeoff=False,
    arming_takes_s=2.5,
    capabilities=2947,
    parameters={"FS_GCS_ENABLE": 1, "WPNAV_SPEED": 500, "WPNAV_ACCEL": 100},
)

COPTER_4_7 = Personality(
    version=(4, 7, 0),
    renamed_parameters={
        "WPNAV_SPEED": ("WP_SPD", 0.01),
        "WPNAV_SPEED_UP": ("WP_SPD_UP", 0.01),
        "WPNAV_SPEED_DN": ("WP_SPD_DN", 0.01),
        "WPNAV_ACCEL": ("WP_ACC", 0.01),
        "WPNAV_ACCEL_C": ("WP_ACC_CNR", 0.01),
        "WPNAV_ACCEL_Z": ("WP_ACC_Z", 0.01),
        "WPNAV_JERK": ("WP_JERK", 1.0),
        "WPNAV_RADIUS": ("WP_RADIUS_M", 0.01),
        "RTL_ALT": ("RTL_ALT_M", 0.01),
        "RTL_ALT_FINAL": ("RTL_ALT_FINAL_M", 0.01),
        "RTL_CLIMB_MIN": ("RTL_CLIMB_MIN_M", 0.01),
        "RTL_SPEED": ("RTL_SPEED_MS", 0.01),
        "LAND_SPEED": ("LAND_SPD_MS", 0.01),
        "LAND_SPEED_HIGH": ("LAND_SPD_HIGH_MS", 0.01),
        "LAND_ALT_LOW": ("LAND_ALT_LOW_M", 0.01),
    },
)


@dataclass(frozen=True, slots=True)
class PilotMode:
    """The pilot's switch: a mode number."""

    mode: int


@dataclass(frozen=True, slots=True)
class FailsafeMode:
    """The vehicle's own decision: a mode number, and the words with which it is announced."""

    mode: int
    text: str


@dataclass(frozen=True, slots=True)
class SetParameter:
    """A parameter takes a value: SIM_BATT_VOLTAGE, say."""

    name: str
    value: float


@dataclass(frozen=True, slots=True)
class Reboot:
    """The autopilot starts anew; in the air the copter falls, so it is found landed where it was."""


@dataclass(frozen=True, slots=True)
class MoveItem:
    """Another station rewrites a mission item: that many metres north of where it was."""

    seq: int
    north_m: float = 20.0


Action = PilotMode | FailsafeMode | SetParameter | Reboot | MoveItem


@dataclass(frozen=True, slots=True)
class Happening:
    """``action`` takes place ``after_s`` of vehicle time behind a moment of the flight.

    ``moment`` is "boot", "upload" (a mission was received), "armed", "takeoff" (commanded) or a mode
    entered, by name ("AUTO", "RTL").
    """

    moment: str
    after_s: float
    action: Action


@dataclass(frozen=True, slots=True)
class Faults:
    """Everything that is wrong with one simulated vehicle."""

    personality: Personality = field(default_factory=Personality)
    mission: MissionFaults = field(default_factory=MissionFaults)
    never_armable: str = ""
    """A prearm reason that never goes away."""
    refuses_arming: str = ""
    """A reason that only the arm command meets."""
    refused_modes: Mapping[int, str] = field(default_factory=dict)
    """Reasons by mode number."""
    climbs: bool = True
    """Whether an accepted take-off leaves the ground."""
    others: tuple[OtherHeartbeat, ...] = ()
    happenings: tuple[Happening, ...] = ()


def old_copter() -> Faults:
    """ArduCopter 3.3: MAVLink 1, no MISSION_ITEM_INT, modes by SET_MODE only, arming that takes 2.5 s."""
    return Faults(personality=COPTER_3_3, mission=MissionFaults(knows_item_int=False))
