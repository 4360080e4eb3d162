"""A mission as plain data: what will be flown, and nothing about how it was found or is sent.

Altitudes are metres in the item's frame, coordinates are degrees. Home, which ArduPilot keeps as
item 0, is not an item here: the first item has sequence number 1 on board.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import IntEnum

HOME_SEQ = 0
FIRST_SEQ = 1
TAKEOFF_REACHED_SHARE = 0.95
"""Share of the take-off altitude at which DroneKit's example counts take-off as done."""


class Command(IntEnum):
    """The MAV_CMD numbers that routes are made of (mavlink.io, common.xml)."""

    WAYPOINT = 16
    LOITER_UNLIMITED = 17
    LOITER_TURNS = 18
    LOITER_TIME = 19
    RETURN_TO_LAUNCH = 20
    LAND = 21
    TAKEOFF = 22
    SPLINE_WAYPOINT = 82
    DELAY = 93
    CONDITION_DELAY = 112
    CONDITION_DISTANCE = 114
    CONDITION_YAW = 115
    CHANGE_SPEED = 178
    SET_ROI = 201


class Frame(IntEnum):
    """The MAV_FRAME numbers that routes are made of (mavlink.io, common.xml)."""

    ABSOLUTE = 0
    MISSION = 2
    RELATIVE = 3
    TERRAIN = 10


WAYPOINT_COMMANDS = frozenset({Command.WAYPOINT, Command.SPLINE_WAYPOINT})
"""Commands that count as waypoints."""


CLIMB_SPEED, DESCENT_SPEED = 2, 3
"""Kinds (param1) of DO_CHANGE_SPEED that are no ground speed."""


@dataclass(frozen=True, slots=True)
class MissionItem:
    """One mission item: ``params`` are MAVLink's param1 to param4."""

    command: int
    frame: int
    params: tuple[float, float, float, float]
    lat_deg: float
    lon_deg: float
    alt_m: float

    @property
    def is_waypoint(self) -> bool:
        """Whether the vehicle flies to this item, straight or along a spline."""
        return self.command in WAYPOINT_COMMANDS

    @property
    def is_spline(self) -> bool:
        """Whether the vehicle flies to this item along a spline."""
        return self.command == Command.SPLINE_WAYPOINT

    @property
    def ground_speed_m_s(self) -> float | None:
        """The horizontal speed that this item sets, None where it sets none."""
        if self.command != Command.CHANGE_SPEED or int(self.params[0]) in (CLIMB_SPEED, DESCENT_SPEED):
            return None
        return self.params[1] if self.params[1] > 0 else None

    @property
    def hold_s(self) -> float:
        """Seconds that the vehicle holds its position at this waypoint."""
        return self.params[0] if self.is_waypoint else 0.0


WAIT_HERE = MissionItem(Command.LOITER_TIME, Frame.RELATIVE, (1.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0)
"""A wait of a second where the vehicle is, at the height at which it is: zeros mean here."""


def waypoint(
    lat_deg: float, lon_deg: float, alt_m: float, *, hold_s: float = 0.0, spline: bool = False
) -> MissionItem:
    """A waypoint ``alt_m`` metres above home; ArduCopter holds for whole seconds only."""
    command = Command.SPLINE_WAYPOINT if spline else Command.WAYPOINT
    return MissionItem(command, Frame.RELATIVE, (float(hold_s), 0.0, 0.0, 0.0), lat_deg, lon_deg, alt_m)


def change_speed(speed_m_s: float) -> MissionItem:
    """DO_CHANGE_SPEED of the horizontal speed (param1 1: ground speed), metres per second."""
    return MissionItem(Command.CHANGE_SPEED, Frame.MISSION, (1.0, float(speed_m_s), 0.0, 0.0), 0.0, 0.0, 0.0)


def change_climb_speed(climb_m_s: float) -> MissionItem:
    """DO_CHANGE_SPEED of the climb speed (param1 2), metres per second; below 0 of the descent speed (3)."""
    kind = CLIMB_SPEED if climb_m_s > 0 else DESCENT_SPEED
    params = (float(kind), abs(float(climb_m_s)), 0.0, 0.0)
    return MissionItem(Command.CHANGE_SPEED, Frame.MISSION, params, 0.0, 0.0, 0.0)


def speed_from_the_start(speed_m_s: float) -> tuple[MissionItem, MissionItem]:
    """What a mission begins with that is flown at one speed: a wait of a second here, and the speed change.

    As AUTO navigates for the first time after a start, ArduCopter 4.1 and later take WPNAV_SPEED, where it is
    not the compiled default, for changed in flight, and undo a speed change that came before
    (AC_WPNav::update_wpnav). The wait lets that happen first: a leg that has begun would keep its speed.
    """
    return WAIT_HERE, change_speed(speed_m_s)


def turn_to(heading_deg: float, rate_deg_s: float = 0.0, direction: int = 0) -> MissionItem:
    """CONDITION_YAW to a heading, 0 to 360.

    Args:
        heading_deg: where to turn to.
        rate_deg_s: how fast; 0 is as fast as the vehicle may.
        direction: 1 clockwise, -1 counterclockwise, 0 the short way round.
    """
    params = (float(heading_deg), float(rate_deg_s), float(direction), 0.0)
    return MissionItem(Command.CONDITION_YAW, Frame.MISSION, params, 0.0, 0.0, 0.0)


def wait(duration_s: float) -> MissionItem:
    """CONDITION_DELAY: seconds until the next DO or CONDITION item may start, while the vehicle flies on."""
    params = (float(duration_s), 0.0, 0.0, 0.0)
    return MissionItem(Command.CONDITION_DELAY, Frame.MISSION, params, 0.0, 0.0, 0.0)


def face(lat_deg: float, lon_deg: float, alt_m: float, frame: int) -> MissionItem:
    """DO_SET_ROI: a vehicle without a gimbal faces a position until it is told otherwise."""
    return MissionItem(Command.SET_ROI, frame, (0.0, 0.0, 0.0, 0.0), lat_deg, lon_deg, alt_m)


@dataclass(frozen=True, slots=True)
class Home:
    """Where the vehicle returns to: degrees, and metres above mean sea level, None where not known."""

    lat_deg: float
    lon_deg: float
    alt_amsl_m: float | None

    @property
    def amsl_m(self) -> float:
        """The height as tracks have it: not a number where it is not known."""
        return math.nan if self.alt_amsl_m is None else self.alt_amsl_m


@dataclass(frozen=True, slots=True)
class Mission:
    """The items to fly, in order, without home."""

    items: tuple[MissionItem, ...]
    home: Home | None = None

    @property
    def waypoints(self) -> tuple[tuple[int, MissionItem], ...]:
        """(sequence number on board, item) of every waypoint, straight or spline."""
        return tuple((seq, item) for seq, item in enumerate(self.items, FIRST_SEQ) if item.is_waypoint)

    @property
    def home_item(self) -> MissionItem:
        """Item 0, in which ArduPilot stores its own home; zeros where home, or its height, is not known."""
        home = self.home or Home(0.0, 0.0, 0.0)
        place = home.lat_deg, home.lon_deg, home.alt_amsl_m or 0.0
        return MissionItem(Command.WAYPOINT, Frame.ABSOLUTE, (0.0, 0.0, 0.0, 0.0), *place)

    def with_home(self, home: Home) -> Mission:
        """The same items under another home."""
        return replace(self, home=home)
