"""AUTO: flies the items of a mission in order.

Sources: AP_Mission.cpp (update, advance_current_nav_cmd: the first DO item of a group starts with
the navigation item after it) and ArduCopter/mode_auto.cpp, whose functions are named below.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from flight_replay.mission.items import FIRST_SEQ, Command
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.auto_do_commands import DoCommands
from flight_replay.simulator.flight.auto_legs import MissionLegs
from flight_replay.simulator.flight.circle import Circle
from flight_replay.simulator.flight.flight_control import FlightControl
from flight_replay.simulator.flight.item_order import ItemOrder
from flight_replay.simulator.flight.landing import Landing
from flight_replay.simulator.flight.rtl import ReturnToLaunch
from flight_replay.simulator.flight.submode import SubMode
from flight_replay.simulator.flight.takeoff import TakeOff
from flight_replay.simulator.mission.local_items import LocalItem

_FIRST_CLIMB_M = 1.0
_NOT_ASKED_S: Final = -1.0


class MissionRun(SubMode):
    """AUTO from item ``start_seq`` on; ``reached`` grows by (seq, seconds since AUTO began).

    DO items count as reached too; ArduCopter reports only the last item of each step. It is ``done`` when
    the vehicle has landed, so that its motors may stop.
    """

    def __init__(self, flight: FlightControl, items: Sequence[LocalItem], start_seq: int = FIRST_SEQ) -> None:
        self._flight = flight
        self._order = ItemOrder(items)
        self._legs = MissionLegs(flight, self._order)
        self._do = DoCommands(flight)
        self.reached: list[tuple[int, float]] = []
        self.completed = False
        self.steps = 0
        self._item: LocalItem | None = None
        self._delays = self._lands = self._is_endless = False
        self._submode: SubMode | None = None
        self._next_seq = start_seq
        self._since_s, self._whole_s = _NOT_ASKED_S, 0.0
        self._circle_radius_m = flight.limits.circle_radius_m
        flight.navigation.start()
        flight.auto_yaw.begin_mission()

    # state

    @property
    def items(self) -> Sequence[LocalItem]:
        """Those of the mission."""
        return self._order.items

    def ends_item(self, seq: int) -> bool:
        """Whether navigation item ``seq`` is flown, and the next step begins with what is after it."""
        return self._item is not None and self._next_seq == seq + 1 and self._is_done(self._item)

    @property
    def time_s(self) -> float:
        """Seconds since AUTO began."""
        return self.steps * self._flight.airframe.dt

    @property
    def passed_s(self) -> float:
        """When the target passed the waypoint that has just been reached, within the last step."""
        return self.time_s - (self._flight.navigation.unused_s if self._submode is None else 0.0)

    @property
    def seq(self) -> int | None:
        """Sequence number of the navigation item that is flown; None before the first."""
        return None if self._item is None else self._item.seq

    @property
    def do_seq(self) -> int | None:
        """Sequence number of the DO or CONDITION item that runs, if one does."""
        return self._do.seq

    @property
    def loitering(self) -> bool:
        """Whether the vehicle loiters at an item that never ends."""
        return self._is_endless and self._flight.navigation.reached

    @property
    def destination_m(self) -> Vector:
        """Where the leg that is flown ends."""
        return self._flight.navigation.destination

    @property
    def landing(self) -> bool:
        """Whether the vehicle descends to land."""
        submode = self._submode
        return isinstance(submode, Landing) or (isinstance(submode, ReturnToLaunch) and submode.landing)

    def step(self) -> None:
        """Go on to the next item if this one is done, and fly one step."""
        if not self.completed:
            self._update()
        flight = self._flight
        if self._submode is not None:
            self._submode.step()
        else:
            flight.navigation.advance()
            flight.auto_yaw.update()
        self.steps += 1
        submode = self._submode
        self.done = submode is not None and isinstance(submode, Landing | ReturnToLaunch) and submode.done
        if self.done and self._item is not None and isinstance(submode, ReturnToLaunch):
            # RTL is reached when it has landed; LAND never is (ModeAuto::verify_RTL, verify_land).
            self.reached.append((self._item.seq, self.time_s))

    def _update(self) -> None:
        if self._item is None:
            self._advance()
        elif self._is_done(self._item):
            self.reached.append((self._item.seq, self.passed_s))
            self._advance()
        if self._do.running:
            self.reached.extend((seq, self.time_s) for seq in self._do.finished(self.time_s))

    def _advance(self) -> None:
        """Start the next navigation item, after the first of the DO items before it."""
        passed, item = self._order.advance(self._next_seq)
        self._do.begin([each for each in passed if not each.is_navigation], self.time_s)
        if item is None:
            self.completed = True
            self._loiter()
            return
        # What is asked at every step is kept here: items are not compiled.
        self._item, self._next_seq, command = item, item.seq + 1, item.command
        self._delays, self._lands = command == Command.DELAY, command == Command.LAND
        self._is_endless = command == Command.LOITER_UNLIMITED
        self._since_s = _NOT_ASKED_S
        self._start(item)

    def _loiter(self) -> None:
        """Hold at the stopping point (ModeAuto::loiter_start)."""
        flight = self._flight
        if not isinstance(self._submode, Landing | ReturnToLaunch):
            self._restart_navigation()
            flight.navigation.set_wp_destination(flight.control.stopping_point())
            flight.auto_yaw.hold()

    # starting items

    def _start(self, item: LocalItem) -> None:
        flight = self._flight
        if item.command == Command.TAKEOFF:
            climb = _FIRST_CLIMB_M if flight.airframe.on_ground else 0.0
            self._submode = TakeOff(flight, max(item.position(flight.position)[2], flight.airframe.u + climb))
        elif item.command == Command.RETURN_TO_LAUNCH:
            self._submode = ReturnToLaunch(flight)
        elif item.command == Command.LAND:
            self._start_landing(item)
        elif item.command == Command.LOITER_TURNS:
            self._restart_navigation()
            self._start_circle(item)
        elif item.command != Command.DELAY:
            self._restart_navigation()
            self._legs.start(item)

    def _restart_navigation(self) -> None:
        """Restart navigation after another submode has flown (ModeAuto::wp_start).

        After a take-off too it starts at the stopping point: up to 4.6 _AutoTakeoff::get_position
        does not give the position that it should start at.
        """
        if self._submode is None:
            return
        self._submode = None
        self._flight.navigation.start(self._do.speed_m_s)
        self._do.restore_speeds()

    def _start_landing(self, item: LocalItem) -> None:
        """Land here, or fly to the item's position first (ModeAuto::do_land)."""
        flight = self._flight
        if item.north_east_m is None:
            self._submode = Landing(flight)
            return
        self._restart_navigation()
        flight.navigation.set_wp_destination((*item.north_east_m, flight.airframe.u))
        flight.auto_yaw.set_default_mode()

    def _start_circle(self, item: LocalItem) -> None:
        """Circle around a position; param1 turns, param3 radius, below 0 counterclockwise.

        Without a radius the last one is kept (ModeAuto::circle_movetoedge_start).
        """
        turns, radius = item.params[0], item.params[2]
        self._circle_radius_m = abs(radius) or self._circle_radius_m
        centre = item.position(self._flight.position)
        self._submode = Circle(self._flight, centre, self._circle_radius_m, -turns if radius < 0 else turns)

    # ending items

    def _is_done(self, item: LocalItem) -> bool:
        """Whether an item is done, so that the next may start (ModeAuto::verify_command)."""
        if self._submode is None and not self._delays and not self._flight.navigation.reached:
            return False
        if self._delays:
            return self._waited(item)
        if self._lands:
            if self._submode is None:
                self._submode = Landing(self._flight)
            return False
        if self._submode is not None:
            return self._submode.done
        return not self._is_endless and self._waited(item)

    def _waited(self, item: LocalItem) -> bool:
        """Whether an item's whole seconds have passed since this was first asked of it."""
        if self._since_s == _NOT_ASKED_S:
            self._since_s, self._whole_s = self.time_s, float(int(item.params[0]))
        return self.time_s - self._since_s >= self._whole_s
