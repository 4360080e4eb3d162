"""AUTO: flies the items of a mission one after the other.

Sources: AP_Mission.cpp (update, advance_current_nav_cmd: the first DO item of a group starts with
the navigation item after it) and ArduCopter/mode_auto.cpp.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import radians

from flight_replay.mission import FIRST_SEQ, Command
from flight_replay.simulator.auto import CONDITION_DELAY, CONDITION_YAW, LocalItem, next_navigation
from flight_replay.simulator.phases import Flight, Landing, Phase, Return, TakeOff
from flight_replay.simulator.scurve import Vector

_FAST_BEFORE = frozenset({Command.WAYPOINT, Command.LOITER_UNLIMITED, Command.LOITER_TIME})
_TIMED = frozenset({Command.WAYPOINT, Command.SPLINE_WAYPOINT, Command.LOITER_TIME})


class MissionRun:
    """AUTO from item ``start_seq`` on; ``reached`` grows by (seq, seconds since AUTO began)."""

    done = False

    def __init__(self, flight: Flight, items: Sequence[LocalItem], start_seq: int = FIRST_SEQ) -> None:
        self._flight = flight
        self._items = items
        self.reached: list[tuple[int, float]] = []
        self.completed = False
        self.time_s = 0.0
        self._item: LocalItem | None = None
        self._phase: Phase | None = None
        self._next_seq = start_seq
        self._doing: list[LocalItem] = []
        self._since_s = -1.0
        flight.navigation.start()

    @property
    def current_seq(self) -> int:
        """The navigation item that is flown, or was last; 0 before the first."""
        return self._item.seq if self._item else 0

    @property
    def loitering(self) -> bool:
        """Whether the vehicle waits at an item that never ends."""
        item = self._item
        return (
            item is not None and item.command == Command.LOITER_UNLIMITED and self._flight.navigation.reached
        )

    @property
    def destination_m(self) -> Vector:
        """Where the leg that is flown ends."""
        return self._flight.navigation.destination

    def step(self) -> None:
        """Check the item, go on to the next if it is done, and fly one step."""
        if not self.completed:
            self._update()
        flight = self._flight
        if self._phase is not None:
            self._phase.step()
        else:
            flight.navigation.advance()
            flight.heading.update()
        self.time_s += flight.body.dt

    def _update(self) -> None:
        if self._item is None:
            self._advance()
        elif self._verify(self._item):
            self.reached.append((self._item.seq, self.time_s))
            self._advance()
        while self._doing and self._did(self._doing[0]):
            self.reached.append((self._doing.pop(0).seq, self.time_s))
            if self._doing:
                self._do(self._doing[0])

    def _advance(self) -> None:
        """Start the next navigation item, after the first of the DO items before it."""
        self._doing = []
        item = next_navigation(self._items, self._next_seq)
        end = item.seq if item else FIRST_SEQ + len(self._items)
        self._doing = list(self._items[self._next_seq - FIRST_SEQ : end - FIRST_SEQ])
        if self._doing:
            self._do(self._doing[0])
        if item is None:
            self.completed = True
            self._hold()
            return
        self._item, self._next_seq = item, item.seq + 1
        self._since_s = -1.0
        self._start(item)

    def _hold(self) -> None:
        """Stay at the stopping point (ModeAuto::loiter_start)."""
        if self._phase is None:
            navigation = self._flight.navigation
            navigation.fly_straight(self._flight.control.stopping_point())
            self._flight.heading.hold()

    # starting items

    def _start(self, item: LocalItem) -> None:
        flight = self._flight
        command = item.command
        after_phase, self._phase = self._phase, None
        if command == Command.TAKEOFF:
            self._phase = TakeOff(flight, item.place(flight.position)[2])
        elif command == Command.RETURN_TO_LAUNCH:
            self._phase = Return(flight)
        elif command == Command.LAND:
            self._start_landing(item)
        elif command != Command.DELAY:
            if after_phase is not None:
                flight.navigation.start()
            self._start_leg(item)

    def _start_landing(self, item: LocalItem) -> None:
        """Land here, or fly to the place first (ModeAuto::do_land)."""
        flight = self._flight
        if item.north_east_m is None:
            self._phase = Landing(flight)
        else:
            flight.navigation.fly_straight((*item.north_east_m, flight.body.u))

    def _start_leg(self, item: LocalItem) -> None:
        """Fly to a place (do_nav_wp, do_spline_wp, do_loiter_unlimited)."""
        flight = self._flight
        navigation = flight.navigation
        if item.command in (Command.LOITER_UNLIMITED, Command.LOITER_TIME):
            n, e, _ = flight.control.stopping_point()
            navigation.fly_straight(item.place((n, e, flight.body.u)))
        else:
            default = navigation.destination if navigation.reached else flight.position
            place = item.place(default)
            if item.command == Command.SPLINE_WAYPOINT:
                navigation.fly_spline(place, self._arriving(item, place, default))
            else:
                navigation.fly_straight(place)
            self._announce(item, place)
        flight.heading.use_default()

    def _following(self, item: LocalItem) -> LocalItem | None:
        """The navigation item after this one, unless the vehicle stops here."""
        return None if item.params[0] >= 1 else next_navigation(self._items, item.seq + 1)

    def _arriving(self, item: LocalItem, place: Vector, origin: Vector) -> Vector:
        """Tangent at the end of a spline leg (get_spline_from_cmd, set_spline_destination)."""
        following = self._following(item)
        if following is None:
            return 0.0, 0.0, 0.0
        beyond = following.place(place)
        base = origin if following.command == Command.SPLINE_WAYPOINT else place
        return beyond[0] - base[0], beyond[1] - base[1], beyond[2] - base[2]

    def _announce(self, item: LocalItem, place: Vector) -> None:
        """Tell navigation of the leg after this one, if it need not stop (ModeAuto::set_next_wp)."""
        following = self._following(item)
        if following is None:
            return
        if following.command in _FAST_BEFORE:
            self._flight.navigation.then_straight(following.place(place))
        elif following.command == Command.SPLINE_WAYPOINT:
            beyond = following.place(place)
            self._flight.navigation.then_spline(beyond, self._arriving(following, beyond, place))

    # ending items

    def _verify(self, item: LocalItem) -> bool:
        """Whether an item is done (ModeAuto::verify_command)."""
        if item.command == Command.DELAY:
            return self._waited(item.params[0])
        if item.command == Command.LAND and self._phase is None:
            if self._flight.navigation.reached:
                self._phase = Landing(self._flight)
            return False
        if self._phase is not None:
            return self._phase.done
        if item.command == Command.LOITER_UNLIMITED or not self._flight.navigation.reached:
            return False
        return self._waited(item.params[0]) if item.command in _TIMED else True

    def _waited(self, seconds: float) -> bool:
        if self._since_s < 0:
            self._since_s = self.time_s
        return self.time_s - self._since_s >= int(seconds)

    def _do(self, item: LocalItem) -> None:
        """Start a DO or CONDITION item."""
        navigation = self._flight.navigation
        if item.command == Command.CHANGE_SPEED and item.params[1] > 0:
            change = {2: navigation.set_speed_up, 3: navigation.set_speed_down}
            change.get(int(item.params[0]), navigation.set_speed)(item.params[1])
        elif item.command == CONDITION_YAW:
            angle, rate, direction, relative = item.params
            self._flight.heading.fix(radians(angle), radians(rate), direction, relative=relative > 0)

    def _did(self, item: LocalItem) -> bool:
        """Whether a DO or CONDITION item is over."""
        if item.command == CONDITION_YAW:
            return self._flight.heading.reached
        return item.command != CONDITION_DELAY
