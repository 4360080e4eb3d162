"""DO and CONDITION items, which run beside the navigation items (mode_auto.cpp, AP_Mission.cpp).

The first of a group starts with the navigation item after it, each further one when the one
before is done; not before the next update, so that another speed changes a leg that has begun with the one
before. A heading asked for by CONDITION_YAW holds until the next navigation item starts, for
that chooses the mode by WP_YAW_BEHAVIOR (ModeAuto::wp_start, do_spline_wp); a position of DO_SET_ROI is
faced on. The first item of a group is started before and resumed at once (verify_yaw), so that its turn
goes on from where the heading is; one behind another item starts with the heading target on the path
already, and turns from there (AP_Mission::update, AutoYaw::set_fixed_yaw, 4.1 to 4.7).
"""

from __future__ import annotations

from collections.abc import Iterator
from math import hypot, radians

from flight_replay.mission.items import Command
from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.flight.flight_control import FlightControl
from flight_replay.simulator.mission.local_items import LocalItem

_UP, _DOWN = 2, 3


class DoCommands(SnapshotPart):
    """The DO items that are running, and the speeds that they have set."""

    def __init__(self, flight: FlightControl) -> None:
        self._flight = flight
        self._items: list[LocalItem] = []
        self._since_s = 0.0
        self._begins = self._waits = False
        self.speed_m_s = self._up_m_s = self._down_m_s = 0.0

    def begin(self, items: list[LocalItem], time_s: float) -> None:
        """Start the first of a group; what is left of the last group is dropped."""
        self._items, self._begins, self._waits = items, True, False
        self._start(time_s)

    @property
    def running(self) -> bool:
        """Whether there are items of a group that are not done."""
        return bool(self._items)

    @property
    def seq(self) -> int | None:
        """Sequence number of the item that runs, if one does."""
        return self._items[0].seq if self._items else None

    def finished(self, time_s: float) -> Iterator[int]:
        """Sequence numbers of items that are done; starts those after them, or with the next update."""
        begins, self._begins = self._begins, False
        if self._waits:
            self._go_on(time_s)
        while self._items and self._is_done(self._items[0], time_s):
            item = self._items.pop(0)
            yield item.seq
            # In the model's long steps a turn ends a step too soon.
            if begins or item.command == Command.CONDITION_YAW:
                self._waits = True
                return
            self._go_on(time_s)

    def _go_on(self, time_s: float) -> None:
        """Start the item that is next."""
        self._waits = False
        self._flight.auto_yaw.update_target()
        self._start(time_s)

    def restore_speeds(self) -> None:
        """Set the climb and descent speeds of the mission again, after navigation has restarted."""
        navigation = self._flight.navigation
        if self._up_m_s > 0:
            navigation.set_speed_up(self._up_m_s)
        if self._down_m_s > 0:
            navigation.set_speed_down(self._down_m_s)

    def _start(self, time_s: float) -> None:
        self._since_s = time_s
        if not self._items:
            return
        item = self._items[0]
        if item.command == Command.CHANGE_SPEED:
            self._change_speed(int(item.params[0]), item.params[1])
        elif item.command == Command.CONDITION_YAW:
            angle, rate, direction, relative = item.params
            self._flight.auto_yaw.set_fixed_yaw(
                radians(angle), radians(rate), direction, relative=relative > 0
            )
        elif item.command == Command.SET_ROI:
            self._set_roi(item)

    def _set_roi(self, item: LocalItem) -> None:
        """Face a position from now on; without one look along the path again (AutoYaw::set_roi)."""
        if item.north_east_m is None:
            self._flight.auto_yaw.set_default_mode()
        else:
            self._flight.auto_yaw.face(item.north_east_m)

    def _change_speed(self, kind: int, speed_m_s: float) -> None:
        """ModeAuto::do_change_speed."""
        navigation = self._flight.navigation
        if speed_m_s <= 0:
            return
        if kind == _UP:
            self._up_m_s = speed_m_s
            navigation.set_speed_up(speed_m_s)
        elif kind == _DOWN:
            self._down_m_s = speed_m_s
            navigation.set_speed_down(speed_m_s)
        else:
            self.speed_m_s = speed_m_s
            navigation.set_speed(speed_m_s)

    def _is_done(self, item: LocalItem, time_s: float) -> bool:
        """Whether an item is done (ModeAuto::verify_command); those without a condition are at once."""
        flight = self._flight
        if item.command == Command.CONDITION_YAW:
            flight.auto_yaw.resume_fixed_yaw()
            return flight.auto_yaw.reached
        if item.command == Command.CONDITION_DELAY:
            return time_s - self._since_s > item.params[0]
        if item.command == Command.CONDITION_DISTANCE:
            n, e, _ = flight.navigation.destination
            return hypot(flight.airframe.n - n, flight.airframe.e - e) < item.params[0]
        return True
