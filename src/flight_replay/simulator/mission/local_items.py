"""A mission as AUTO flies it: its items in ArduPilot's metres north, east and up of home."""

from __future__ import annotations

from dataclasses import dataclass

from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.mission.items import FIRST_SEQ, Command, Frame, Mission
from flight_replay.simulator.mission.stored_params import PARAM_RULES, stored_altitude_cm, stored_params

Params = tuple[float, float, float, float]

DO_JUMP = 177
LOITER_TO_ALTITUDE, GUIDED_ENABLE, PAYLOAD_PLACE, SET_HOME, JUMP_TO_TAG = 31, 92, 94, 179, 601
_VTOL_TAKEOFF, _VTOL_LAND = 84, 85
_LAST_NAVIGATION, _SET_YAW_SPEED = 95, 213
_ABSOLUTE_FRAMES = frozenset({Frame.ABSOLUTE, 5})
_TERRAIN_FRAMES = frozenset({Frame.TERRAIN, 11})
FLOWN = frozenset(
    {
        Command.WAYPOINT,
        Command.SPLINE_WAYPOINT,
        Command.LOITER_UNLIMITED,
        Command.LOITER_TURNS,
        Command.LOITER_TIME,
        Command.RETURN_TO_LAUNCH,
        Command.LAND,
        Command.TAKEOFF,
        Command.DELAY,
    }
)
"""Navigation items that are flown; those that ArduCopter lacks are skipped (start_command)."""
_NOT_SIMULATED = frozenset({LOITER_TO_ALTITUDE, GUIDED_ENABLE, PAYLOAD_PLACE, SET_HOME, JUMP_TO_TAG})


def is_navigation(command: int) -> bool:
    """Whether a command is a navigation command, not a DO or CONDITION command (AP_Mission::is_nav_cmd)."""
    return command <= _LAST_NAVIGATION or command == _SET_YAW_SPEED


def copter_command(command: int) -> int:
    """The command that a copter runs: VTOL take-off and landing are its own (start_command)."""
    return {_VTOL_TAKEOFF: int(Command.TAKEOFF), _VTOL_LAND: int(Command.LAND)}.get(command, command)


@dataclass(frozen=True, slots=True)
class LocalItem:
    """A mission item in the local frame; ``north_east_m`` None is "here", ``up_m`` None "this altitude"."""

    seq: int
    command: int
    params: Params
    north_east_m: tuple[float, float] | None
    up_m: float | None
    above_terrain: bool = False
    """Whether ``up_m`` is above terrain, which here is level with home."""

    @property
    def is_navigation(self) -> bool:
        """Whether it is a navigation item, not a DO or CONDITION item."""
        return is_navigation(self.command)

    @property
    def is_simulated(self) -> bool:
        """Whether the model does as ArduCopter; it has no time of day, for NAV_DELAY without seconds."""
        until_time_of_day = self.command == Command.DELAY and self.params[0] <= 0
        return self.command not in _NOT_SIMULATED and not until_time_of_day

    def position(self, default: tuple[float, float, float]) -> tuple[float, float, float]:
        """The item's position; what it leaves open is that of ``default`` (ModeAuto::loc_from_cmd)."""
        n, e = self.north_east_m or default[:2]
        return n, e, default[2] if self.up_m is None else self.up_m


def local_items(mission: Mission, frame: FlatFrame, home_amsl_m: float) -> tuple[LocalItem, ...]:
    """The items of a mission in metres around ``frame``'s origin and above home.

    Args:
        mission: items with sequence numbers from 1.
        frame: ArduPilot's metres around home.
        home_amsl_m: home's height above sea level, for items in the absolute frame. Heights above
            terrain count from home: the ground is level here.
    """
    north_east = frame.to_metres_on_board(
        [item.lat_deg for item in mission.items], [item.lon_deg for item in mission.items]
    )
    items = []
    for seq, (item, (north, east)) in enumerate(
        zip(mission.items, north_east.tolist(), strict=True), FIRST_SEQ
    ):
        is_here = item.lat_deg == 0 and item.lon_deg == 0
        alt_m = stored_altitude_cm(item.alt_m) / 100.0
        up = alt_m - (home_amsl_m if item.frame in _ABSOLUTE_FRAMES else 0.0)
        items.append(
            LocalItem(
                seq,
                copter_command(int(item.command)),
                stored_params(item.command, item.params) if item.command in PARAM_RULES else item.params,
                None if is_here else (north, east),
                None if alt_m == 0 else up,
                item.frame in _TERRAIN_FRAMES,
            )
        )
    return tuple(items)
