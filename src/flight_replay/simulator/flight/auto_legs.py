"""How AUTO flies from one waypoint to the next, and tells navigation what comes after it.

Source: ArduCopter/mode_auto.cpp, whose functions are named below.
"""

from __future__ import annotations

from flight_replay.mission.items import Command
from flight_replay.simulator.dynamics.vector import Vector, minus
from flight_replay.simulator.flight.phase import Flight
from flight_replay.simulator.mission.item_order import ItemOrder
from flight_replay.simulator.mission.local_items import LocalItem

_STRAIGHT_NEXT = frozenset({Command.WAYPOINT, Command.LOITER_UNLIMITED, Command.LOITER_TIME})
_LOITERS = frozenset({Command.LOITER_UNLIMITED, Command.LOITER_TIME})


class MissionLegs:
    """Legs to the places of a mission's items; a waypoint is a stop unless the leg after it is known."""

    def __init__(self, flight: Flight, order: ItemOrder) -> None:
        self._flight = flight
        self._order = order

    def start(self, item: LocalItem) -> None:
        """Fly to an item's place (do_nav_wp, do_spline_wp, do_loiter_unlimited)."""
        flight = self._flight
        navigation = flight.navigation
        if item.command in _LOITERS:
            n, e, _ = flight.control.stopping_point()
            navigation.fly_straight(item.place((n, e, flight.body.u)))
        else:
            default = navigation.destination if navigation.reached else flight.position
            place = item.place(default)
            if item.command == Command.SPLINE_WAYPOINT:
                navigation.fly_spline(place, self._arriving(item, place, navigation.destination))
            else:
                navigation.fly_straight(place)
            self._announce(item, place)
        flight.heading.use_default()

    def _following(self, item: LocalItem) -> LocalItem | None:
        """The navigation item after this one, unless the vehicle stops here.

        It does so between heights above home and above terrain (AC_WPNav::set_wp_destination_next).
        """
        following = None if item.params[0] >= 1 else self._order.peek(item.seq + 1)
        return following if following and following.above_terrain == item.above_terrain else None

    def _arriving(self, item: LocalItem, place: Vector, origin: Vector) -> Vector:
        """Tangent at the end of a spline leg (get_spline_from_cmd, AC_WPNav::set_spline_destination)."""
        following = self._following(item)
        if following is None:
            return 0.0, 0.0, 0.0
        return minus(
            following.place(place), origin if following.command == Command.SPLINE_WAYPOINT else place
        )

    def _announce(self, item: LocalItem, place: Vector) -> None:
        """Tell navigation of the leg after this one, if it need not stop (ModeAuto::set_next_wp)."""
        following = self._following(item)
        if following is None:
            return
        beyond = following.place(place)
        if following.command in _STRAIGHT_NEXT:
            self._flight.navigation.then_straight(beyond)
        elif following.command == Command.SPLINE_WAYPOINT:
            self._flight.navigation.then_spline(beyond, self._arriving(following, beyond, place))
