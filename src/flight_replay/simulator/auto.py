"""A mission as AUTO is given it: its items in ArduPilot's metres around home.

Places are metres north, east and up of home; AUTO itself is in ``auto_run``.
"""

from __future__ import annotations

from dataclasses import dataclass

from flight_replay.mission import FIRST_SEQ, Command, Frame, Mission
from flight_replay.simulator.flat import FlatFrame

Params = tuple[float, float, float, float]

CONDITION_DELAY, CONDITION_DISTANCE, CONDITION_YAW, DO_JUMP = 112, 114, 115, 177
_ABSOLUTE_FRAMES = frozenset({Frame.ABSOLUTE, 5})
NAVIGATION = frozenset(
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


@dataclass(frozen=True, slots=True)
class LocalItem:
    """A mission item in the local frame; ``north_east_m`` None is "here", ``up_m`` None "keep altitude"."""

    seq: int
    command: int
    params: Params
    north_east_m: tuple[float, float] | None
    up_m: float | None

    @property
    def is_navigation(self) -> bool:
        """Whether AUTO flies this item, as against doing it on the way."""
        return self.command in NAVIGATION

    def place(self, default: tuple[float, float, float]) -> tuple[float, float, float]:
        """Where the item is, taking what it leaves open from ``default`` (ModeAuto::loc_from_cmd)."""
        n, e = self.north_east_m or default[:2]
        return n, e, default[2] if self.up_m is None else self.up_m


def local_items(mission: Mission, frame: FlatFrame, home_amsl_m: float = 0.0) -> tuple[LocalItem, ...]:
    """The items of a mission in metres around ``frame``'s origin and above home.

    Args:
        mission: items with sequence numbers from 1.
        frame: ArduPilot's metres around home.
        home_amsl_m: home's height above sea level, for items in the absolute frame. Heights above
            terrain count from home: the ground is level here.
    """
    places = frame.on_board(
        [item.lat_deg for item in mission.items], [item.lon_deg for item in mission.items]
    )
    items = []
    for seq, (item, (north, east)) in enumerate(zip(mission.items, places.tolist(), strict=True), FIRST_SEQ):
        anywhere = item.lat_deg == 0 and item.lon_deg == 0
        up = item.alt_m - (home_amsl_m if item.frame in _ABSOLUTE_FRAMES else 0.0)
        items.append(
            LocalItem(
                seq,
                int(item.command),
                item.params,
                None if anywhere else (north, east),
                None if item.alt_m == 0 else up,
            )
        )
    return tuple(items)
