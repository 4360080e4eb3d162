"""How AUTO flies from one waypoint to the next, with the leg after it known to navigation.

Source: ArduCopter/mode_auto.cpp, whose functions are named below.
"""

from __future__ import annotations

from flight_replay.mission.items import Command
from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.dynamics.vector import Vector, minus
from flight_replay.simulator.flight.flight_control import FlightControl
from flight_replay.simulator.flight.item_order import ItemOrder
from flight_replay.simulator.mission.local_items import LocalItem

_STRAIGHT_NEXT = frozenset({Command.WAYPOINT, Command.LOITER_UNLIMITED, Command.LOITER_TIME})
_LOITERS = frozenset({Command.LOITER_UNLIMITED, Command.LOITER_TIME})


class MissionLegs(SnapshotPart):
    """Legs to a mission's items; the copter stops at a waypoint unless the leg after it is known."""

    def __init__(self, flight: FlightControl, order: ItemOrder) -> None:
        self._flight = flight
        self._order = order

    def start(self, item: LocalItem) -> None:
        """Fly to an item's position (do_nav_wp, do_spline_wp, do_loiter_unlimited)."""
        flight = self._flight
        navigation = flight.navigation
        if item.command in _LOITERS:
            n, e, _ = flight.control.stopping_point()
            navigation.set_wp_destination(item.position((n, e, flight.airframe.u)))
        else:
            default = navigation.destination if navigation.reached else flight.position
            position = item.position(default)
            if item.command == Command.SPLINE_WAYPOINT:
                navigation.set_spline_destination(
                    position, self._destination_tangent(item, position, navigation.destination)
                )
            else:
                navigation.set_wp_destination(position)
            self._set_next(item, position)
        flight.auto_yaw.begin_leg()

    def _following(self, item: LocalItem) -> LocalItem | None:
        """The navigation item after this one, unless the vehicle stops here.

        It also stops between altitudes above home and above terrain (AC_WPNav::set_wp_destination_next).
        """
        following = None if item.params[0] >= 1 else self._order.peek(item.seq + 1)
        return following if following and following.above_terrain == item.above_terrain else None

    def _destination_tangent(self, item: LocalItem, position: Vector, origin: Vector) -> Vector:
        """Tangent at the end of a spline leg (get_spline_from_cmd, AC_WPNav::set_spline_destination)."""
        following = self._following(item)
        if following is None:
            return 0.0, 0.0, 0.0
        return minus(
            following.position(position), origin if following.command == Command.SPLINE_WAYPOINT else position
        )

    def _set_next(self, item: LocalItem, position: Vector) -> None:
        """Set the leg after this one, if the vehicle need not stop (ModeAuto::set_next_wp)."""
        following = self._following(item)
        if following is None:
            return
        beyond = following.position(position)
        if following.command in _STRAIGHT_NEXT:
            self._flight.navigation.set_wp_destination_next(beyond)
        elif following.command == Command.SPLINE_WAYPOINT:
            self._flight.navigation.set_spline_destination_next(
                beyond, self._destination_tangent(following, beyond, position)
            )
