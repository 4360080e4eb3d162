"""What can be wrong with the simulated vehicle, as plain data for tests and rehearsals.

``Faults()`` is an ArduCopter 4.6 without faults. Each field makes one thing different; ``script`` lists what
goes wrong in flight, and when.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from flight_replay.simulator.autopilot.parameter_table import Parameters
from flight_replay.simulator.mission.store import CAPACITY


@dataclass(frozen=True, slots=True)
class MissionFaults:
    """What is wrong with the mission protocol: results are MAV_MISSION_RESULT values.

    ``result_of_item`` answers the item of that sequence number instead of storing it,
    ``result_of_upload`` the whole upload after its last item.
    """

    supports_item_int: bool = True
    capacity: int = CAPACITY
    result_of_item: Mapping[int, int] = field(default_factory=dict)
    result_of_upload: int = 0


@dataclass(frozen=True, slots=True)
class OtherHeartbeat:
    """A heartbeat of another component or system on the same link, once a second.

    With a ``location`` (degrees times 1e7, millimetres above home) its position is sent as well.
    """

    system: int
    component: int
    vehicle_type: int
    autopilot: int = 8
    base_mode: int = 0
    custom_mode: int = 0
    system_status: int = 4
    location: tuple[int, int, int] | None = None

    @property
    def fields(self) -> tuple[int, int, int, int, int]:
        """The fields of HEARTBEAT, in its order."""
        return self.vehicle_type, self.autopilot, self.base_mode, self.custom_mode, self.system_status


GIMBAL = OtherHeartbeat(1, 154, 26)
RADIO = OtherHeartbeat(51, 68, 0)
ADSB_RECEIVER = OtherHeartbeat(1, 156, 27)
SECOND_COPTER = OtherHeartbeat(
    2, 1, 2, autopilot=3, base_mode=209, custom_mode=5, location=(473900000, 85400000, 77000)
)


# MAV_PROTOCOL_CAPABILITY: MISSION_FLOAT, PARAM_FLOAT, MISSION_INT, COMMAND_INT,
# SET_POSITION_TARGET_LOCAL_NED and _GLOBAL_INT, MAVLINK2, MISSION_FENCE. ArduCopter has more (files, say).
_CAPABILITIES = 1 | 2 | 4 | 8 | 128 | 256 | 8192 | 16384


@dataclass(frozen=True, slots=True)
class GuidedSupport:
    """What a firmware understands of the targets that are streamed to it in GUIDED."""

    acceleration: bool = True
    """Whether it takes accelerations; without, it drops a target that has one."""
    yaw: bool = True
    """Whether it turns as targets say; without, it ignores what they say."""
    stops_at_nonsense: bool = True
    """Whether a target that makes no sense stops it."""


@dataclass(frozen=True, slots=True)
class Firmware:
    """Which vehicle and firmware it is: ``vehicle_type`` is a MAV_TYPE."""

    vehicle_type: int = 2
    name: str = "ArduCopter"
    version: tuple[int, int, int] = (4, 6, 0)
    mavlink1: bool = False
    """Whether it knows MAVLink 1 only."""
    unknown_commands: frozenset[int] = frozenset()
    """MAV_CMDs of the built-in copter that this firmware lacks."""
    unknown_messages: frozenset[str] = frozenset()
    """Messages, by name, that this firmware does not answer."""
    acks_set_mode: bool = False
    """Whether SET_MODE, a message, is answered with a COMMAND_ACK of its message number."""
    auto_needs_takeoff: bool = True
    """Whether AUTO is refused on the ground without a take-off item."""
    checks_speed: bool = True
    """Whether the first mission after a start goes on at WPNAV_SPEED if that is not the compiled default."""
    arming_delay_s: float = 0.0
    """Time between the accepted command and the armed flag."""
    capabilities: int = _CAPABILITIES
    guided: GuidedSupport = field(default_factory=GuidedSupport)
    parameters: Mapping[str, float] = field(default_factory=dict)
    """Defaults that differ from those of 4.6."""
    absent_parameters: frozenset[str] = frozenset()
    """Parameters of 4.6 that this firmware lacks."""
    renamed_parameters: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    """New name and factor to the new unit, by 4.6 name."""

    def parameter_table(self, values: Mapping[str, float] | None = None) -> Parameters:
        """The parameters of this firmware with some values changed; KeyError for an unknown name."""
        changed = {**self.parameters, **(values or {})}
        return Parameters(changed, self.renamed_parameters, self.absent_parameters)

    @property
    def banner(self) -> str:
        """The firmware's name and version, as its first status text gives it."""
        return f"{self.name} V{'.'.join(str(part) for part in self.version)}"


PLANE = Firmware(vehicle_type=1, name="ArduPlane")
ROVER = Firmware(vehicle_type=10, name="ArduRover")
COPTER_3_3 = Firmware(
    version=(3, 3, 0),
    mavlink1=True,
    unknown_commands=frozenset({176, 510, 511, 512, 401, 224, 42428}),
    unknown_messages=frozenset({"TIMESYNC"}),
    acks_set_mode=True,
    auto_needs_takeoff=False,
    checks_speed=False,
    arming_delay_s=2.5,
    capabilities=2947,
    guided=GuidedSupport(acceleration=False, yaw=False, stops_at_nonsense=False),
    parameters={"FS_GCS_ENABLE": 1, "WPNAV_SPEED": 500, "WPNAV_ACCEL": 100},
    absent_parameters=frozenset({"GUID_TIMEOUT", "GUID_OPTIONS"}),
)

COPTER_4_7 = Firmware(
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
    """The pilot switches to a mode, by number."""

    mode: int


@dataclass(frozen=True, slots=True)
class FailsafeMode:
    """A failsafe changes to a mode, by number, and sends a status text."""

    mode: int
    text: str


@dataclass(frozen=True, slots=True)
class SetParameter:
    """A parameter changes: SIM_BATT_VOLTAGE, say."""

    name: str
    value: float


@dataclass(frozen=True, slots=True)
class Reboot:
    """The autopilot reboots; in the air the copter falls, and is on the ground below afterwards."""


@dataclass(frozen=True, slots=True)
class MoveItem:
    """Another station moves a mission item so many metres north."""

    seq: int
    north_m: float = 20.0


Action = PilotMode | FailsafeMode | SetParameter | Reboot | MoveItem


@dataclass(frozen=True, slots=True)
class ScriptedFault:
    """``action`` takes place ``after_s`` seconds of vehicle time after ``trigger``.

    A trigger is "boot", "upload" (a mission was received), "armed", "takeoff" (commanded), "target"
    (one that moves was followed) or the name of a mode that is entered ("AUTO", "RTL").
    """

    trigger: str
    after_s: float
    action: Action


@dataclass(frozen=True, slots=True)
class Faults:
    """Everything that is wrong with one simulated vehicle."""

    firmware: Firmware = field(default_factory=Firmware)
    mission: MissionFaults = field(default_factory=MissionFaults)
    prearm_failure: str = ""
    """A prearm check that always fails, by its text."""
    arm_failure: str = ""
    """A check that fails at the arm command only, by its text."""
    refused_modes: Mapping[int, str] = field(default_factory=dict)
    """Why modes are refused, by mode number."""
    takeoff_climbs: bool = True
    """Whether the copter leaves the ground after an accepted take-off command."""
    other_heartbeats: tuple[OtherHeartbeat, ...] = ()
    script: tuple[ScriptedFault, ...] = ()


def old_copter() -> Faults:
    """ArduCopter 3.3: MAVLink 1, no MISSION_ITEM_INT, no TIMESYNC, modes by SET_MODE only, slow arming."""
    return Faults(firmware=COPTER_3_3, mission=MissionFaults(supports_item_int=False))
