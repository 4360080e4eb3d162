"""The state of the mission in AUTO: the current item, start, resume and end, and the status texts.

Sources: AP_Mission.cpp (start, resume, stop, reset, set_current_cmd), mode_auto.cpp (init, run,
exit_mission). The flying itself is ``simulator/flight/auto.py``.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest

from flight_replay.events import Severity
from flight_replay.flight_modes import CopterMode
from flight_replay.mavlink import dialect
from flight_replay.mission.items import FIRST_SEQ, Command
from flight_replay.simulator.autopilot.context import AutopilotContext
from flight_replay.simulator.flight.auto import MissionRun
from flight_replay.simulator.flight.item_order import ItemOrder
from flight_replay.simulator.mission.item_names import REPORTED_AS_REACHED, name_of
from flight_replay.simulator.mission.local_items import LocalItem

_NO_MISSION, _NOT_STARTED = dialect.MISSION_STATE_NO_MISSION, dialect.MISSION_STATE_NOT_STARTED
_ACTIVE, _COMPLETE = dialect.MISSION_STATE_ACTIVE, dialect.MISSION_STATE_COMPLETE
# Items from the current one on whose change restarts its leg (ModeAuto::check_for_mission_change).
_CHECKED_ITEMS = 3
# Conditions, DO_CHANGE_SPEED, _SET_HOME, _RETURN_PATH_START, _LAND_START, _SET_ROI, _MOUNT_CONTROL,
# _FENCE_ENABLE, _GUIDED_LIMITS and _WINCH.
_REPORTED_COMMANDS = frozenset({112, 114, 115, 178, 179, 188, 189, 201, 205, 207, 222, 42600})
_ALLOWS_TAKEOFF = 1 << 1  # AUTO_OPTIONS: AllowTakeOffWithoutRaisingThrottle


class MissionControl:
    """``seq`` is the navigation item that is flown or was last, 0 before the first."""

    def __init__(self, autopilot: AutopilotContext) -> None:
        self._autopilot = autopilot
        self.seq = 0
        self._state = _NOT_STARTED
        self._waiting = False
        self._takeoff_allowed = False
        self._run: MissionRun | None = None
        self._reported = 0
        self._completed = False
        self._changes = 0
        self._items: list[LocalItem] = []
        self._order = ItemOrder(self._items)
        self._start_seq = self._next_seq = self._resume_seq = FIRST_SEQ

    @property
    def state(self) -> int:
        """MISSION_STATE."""
        return int(self._state if len(self._autopilot.store) > 1 else _NO_MISSION)

    # commands

    def may_begin(self) -> bool:
        """Whether AUTO may be entered; from the ground, armed, only with a take-off item first."""
        autopilot = self._autopilot
        if not self._can_be_simulated(self._local_items()):
            return False
        if not autopilot.armed:
            return True
        if len(autopilot.store) <= FIRST_SEQ:
            return False
        needs_takeoff = autopilot.flight.landed and autopilot.faults.firmware.auto_needs_takeoff
        if needs_takeoff and not autopilot.store.starts_with_takeoff(self._first()):
            autopilot.say(Severity.CRITICAL, "Auto: Missing Takeoff Cmd")
            return False
        return True

    def _can_be_simulated(self, items: Sequence[LocalItem]) -> bool:
        """Whether every item is simulated; reports those that are not."""
        for item in items:
            if not item.is_simulated:
                self._autopilot.say(
                    Severity.CRITICAL, f"Auto: {item.seq} {name_of(item.command)} is not simulated"
                )
        return all(item.is_simulated for item in items)

    def _first(self) -> int:
        """The item to start or resume at: MIS_RESTART 1 starts at the first."""
        restarts = self._autopilot.parameters["MIS_RESTART"] == 1 or self._state == _COMPLETE
        return FIRST_SEQ if restarts or self.seq == 0 else self._resume_seq

    def wait_to_start(self) -> None:
        """AUTO was entered: start at the next step."""
        self._waiting = True
        self._takeoff_allowed = bool(int(self._autopilot.parameters["AUTO_OPTIONS"]) & _ALLOWS_TAKEOFF)

    def start(self) -> None:
        """MISSION_START in AUTO: the mission may leave the ground, and begins anew if it is complete."""
        self._takeoff_allowed = True
        if self._state == _COMPLETE and not self._waiting:
            self._start_at(FIRST_SEQ)

    def stop(self) -> None:
        """AUTO was left: stop the mission, which goes on with the DO item that runs, if one does."""
        if self._run is not None and self._run.do_seq is not None:
            self._resume_seq = self._run.do_seq
        self._waiting, self._run = False, None
        if self._state == _ACTIVE:
            self._state = _NOT_STARTED

    def reset(self) -> None:
        """Back to the first item, as disarming does."""
        self.seq, self._run = 0, None
        self._takeoff_allowed = False

    def clear(self) -> bool:
        """Go back to before the first item; False if the mission may not be cleared, as it is flown."""
        if self._autopilot.armed and self._state == _ACTIVE:
            return False
        self.reset()
        self._state = _NOT_STARTED
        return True

    def set_current(self, seq: int) -> bool:
        """Make an item the current one, at once if the mission runs; False if there is no such item."""
        store = self._autopilot.store
        if seq >= len(store) or len(store) == 1:
            return False
        target = store.next_navigation(max(seq, FIRST_SEQ))
        if target is None:
            return False
        if self._state == _ACTIVE:
            self._start_at(max(seq, FIRST_SEQ))
            return True
        # What is done on the way to that item is not left out (AP_Mission::set_current_cmd, resume).
        self.seq, self._resume_seq = target, max(seq, FIRST_SEQ)
        if self._state == _COMPLETE:
            self._state = _NOT_STARTED
        return True

    def home_moved(self) -> None:
        """Altitudes above home count from elsewhere, for the legs that are not flown yet."""
        if self._run is not None:
            self._items[:] = self._local_items()

    # time

    def update(self) -> None:
        """Start when AUTO waits for it, follow the flight, and report its progress."""
        autopilot = self._autopilot
        if autopilot.mode != CopterMode.AUTO:
            return
        if self._waiting and autopilot.sensors.origin_set:
            self._waiting = False
            self._start_at(self._first())
        elif self._state == _ACTIVE and (self.seq == 0 or self._was_rewritten()):
            self._start_at(FIRST_SEQ)
        if self._run is None and self._state == _ACTIVE and self._can_fly():
            self._items[:] = self._local_items()
            self._run = autopilot.flight.fly_mission(self._items, self._start_seq)
        if self._run is not None:
            self._follow_run(self._run)

    def _was_rewritten(self) -> bool:
        """Whether a mission that waits on the ground was changed."""
        store = self._autopilot.store
        return self._run is None and self._changes != store.changes and not store.receiving

    def _can_fly(self) -> bool:
        autopilot = self._autopilot
        return autopilot.armed and (not autopilot.flight.landed or self._takeoff_allowed)

    def _start_at(self, seq: int) -> None:
        """Run the mission from an item on; it is flown as soon as the vehicle may leave the ground."""
        self._changes = self._autopilot.store.changes
        self._items = self._local_items()
        self._order, self._start_seq, self._next_seq = ItemOrder(self._items), seq, seq
        self._reported, self._completed = 0, False
        self._run = None
        self._state = _ACTIVE if self._announce_next() else _COMPLETE

    def _follow_run(self, run: MissionRun) -> None:
        """Report what was reached since the last step, and note the end."""
        autopilot = self._autopilot
        if self._changes != autopilot.store.changes and not autopilot.store.receiving:
            self._apply_changes()
            return
        reached = [seq for seq, _ in run.reached[self._reported :]]
        self._reported = len(run.reached)
        has_next = True
        for seq in reached:
            item = self._items[seq - FIRST_SEQ]
            if item.command in REPORTED_AS_REACHED:
                autopilot.say(Severity.INFO, f"Reached command #{seq}")
            if item.is_navigation:
                has_next = self._announce_next()
        self._report(reached)
        # The run ends with the landing of an RTL item, before it asks for the item after it.
        if (run.completed or (run.done and not has_next)) and not self._completed:
            self._completed = True
            self._state = _COMPLETE
            if autopilot.flight.landed:
                autopilot.disarm()

    def _report(self, reached: Sequence[int]) -> None:
        """Report items as reached, but of DO items only those of ModeAuto::verify_command.

        A DO item that is done at once replaces the navigation item before it.
        """
        flown = {seq: self._items[seq - FIRST_SEQ].is_navigation for seq in reached}
        reported = [
            seq for seq in reached if flown[seq] or self._items[seq - FIRST_SEQ].command in _REPORTED_COMMANDS
        ]
        for seq, after in zip_longest(reported, reported[1:]):
            if after is None or not flown[seq]:
                self._autopilot.item_reached(seq)

    def _announce_next(self) -> bool:
        """Report the next item to fly, if there is one, and those that are done on the way to it."""
        passed, item = self._order.advance(self._next_seq)
        for each in [*passed, item] if item else passed:
            self._autopilot.say(Severity.INFO, f"Mission: {each.seq} {name_of(each.command)}")
        if item:
            self.seq = self._resume_seq = item.seq
            self._next_seq = item.seq + 1
            if item.command == Command.DELAY:
                self._autopilot.say(Severity.INFO, f"Delaying {item.params[0]:.0f} sec")
        return item is not None

    def _apply_changes(self) -> None:
        """A station changed the mission that is flown (ModeAuto::run, check_for_mission_change)."""
        seq, before = self.seq, self._items
        self._changes = self._autopilot.store.changes
        now = self._local_items()
        self._can_be_simulated(now)
        first = max(seq - FIRST_SEQ, 0)
        if now[first : first + _CHECKED_ITEMS] == before[first : first + _CHECKED_ITEMS]:
            before[:] = now
        else:
            self._start_at(seq if 0 < seq <= len(now) else FIRST_SEQ)
            self._autopilot.say(Severity.CRITICAL, "Auto mission changed, restarted command")

    def _local_items(self) -> list[LocalItem]:
        autopilot = self._autopilot
        return [
            autopilot.ekf_frame.local_item(seq, item, autopilot.flight.armed_m)
            for seq, item in enumerate(autopilot.store.items[FIRST_SEQ:], FIRST_SEQ)
        ]
