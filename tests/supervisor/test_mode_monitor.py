"""Who chose a flight mode: two heartbeats in a row decide, three without a reason, none after a reboot."""

from __future__ import annotations

import pytest

from flight_replay.supervisor.mode_monitor import ModeMonitor, UnexpectedHeartbeats


def monitor(*heartbeats: tuple[str, bool], expected: str = "AUTO", armed: bool = True) -> ModeMonitor:
    """A monitor that expects one mode, with heartbeats one second apart, from 100 s on."""
    modes = ModeMonitor()
    modes.heartbeat(expected, armed, 99.0)
    modes.expect(expected)
    for index, (mode, is_armed) in enumerate(heartbeats):
        modes.heartbeat(mode, is_armed, 100.0 + index)
    return modes


LOITER, RTL = ("LOITER", True), ("RTL", True)


@pytest.mark.parametrize(
    ("heartbeats", "explained", "taken"),
    [
        ([], True, False),
        ([LOITER], True, False),
        ([LOITER, LOITER], False, True),
        ([RTL, RTL], True, True),
        ([RTL, RTL], False, False),
        ([RTL, RTL, RTL], False, True),
        ([LOITER, ("AUTO", True), LOITER], False, False),
    ],
    ids=["none", "one", "pilot", "failsafe with reason", "failsafe without", "three", "not in a row"],
)
def test_heartbeats_in_a_row_show_who_chose_the_mode(
    heartbeats: list[tuple[str, bool]], explained: bool, taken: bool
) -> None:
    """Two of a pilot's mode, or of a failsafe's with its reason; three of a failsafe's without."""
    assert monitor(*heartbeats).taken_over(110.0, explained=explained) is taken


@pytest.mark.parametrize("mode", ["RTL", "SMART_RTL", "LAND", "BRAKE", "AUTO_RTL", "AVOID_ADSB"])
def test_modes_that_a_failsafe_enters(mode: str) -> None:
    """ArduCopter's failsafe actions, and where it keeps away from another aircraft."""
    assert monitor((mode, True)).is_failsafe


def test_other_modes_are_not_a_failsafes() -> None:
    """A failsafe never enters them."""
    assert not monitor(LOITER).is_failsafe
    assert not ModeMonitor().is_failsafe


def test_no_mode_is_unexpected_before_one_is_expected() -> None:
    """A vehicle may be in any mode when the program connects."""
    modes = ModeMonitor()
    for wall_s in (1.0, 2.0, 3.0):
        modes.heartbeat("LOITER", True, wall_s)
    assert modes.unexpected.count == 0
    assert not modes.changed


def test_a_requested_mode_is_entered_with_its_heartbeat() -> None:
    """Until then the mode before it is expected too, afterwards no longer."""
    modes = monitor(expected="GUIDED")
    modes.expect_change("AUTO")
    assert not modes.changed
    modes.heartbeat("GUIDED", True, 100.0)
    assert (modes.changed, modes.unexpected.count) == (False, 0)
    modes.heartbeat("AUTO", True, 101.0)
    assert (modes.changed, modes.unexpected.count) == (True, 0)
    modes.heartbeat("GUIDED", True, 102.0)
    assert (modes.changed, modes.unexpected.count) == (True, 1)


def test_a_mode_that_the_vehicle_is_in_already_needs_no_change() -> None:
    """It counts as entered at once, also if it was unexpected before."""
    modes = monitor(RTL)
    assert modes.unexpected.count == 1
    modes.expect_change("RTL")
    assert modes.changed
    assert modes.unexpected.count == 0


def test_a_change_is_expected_from_the_vehicles_first_mode_too() -> None:
    """Where nothing was expected before, the mode of the latest heartbeat is."""
    modes = ModeMonitor()
    modes.heartbeat("STABILIZE", False, 99.0)
    modes.expect_change("GUIDED")
    modes.heartbeat("STABILIZE", False, 100.0)
    assert modes.unexpected.count == 0
    modes.heartbeat("LOITER", False, 101.0)
    assert modes.unexpected.count == 1


def test_a_second_change_starts_unconfirmed() -> None:
    """The change before it does not count for it."""
    modes = monitor(expected="GUIDED")
    modes.expect_change("GUIDED")
    assert modes.changed
    modes.expect_change("AUTO")
    assert not modes.changed


def test_heartbeats_of_another_mode_go_on_counting_over_a_request() -> None:
    """A pilot's choice just before AUTO is requested is still a pilot's choice."""
    modes = monitor(LOITER, expected="GUIDED")
    modes.expect_change("AUTO")
    modes.heartbeat("LOITER", True, 101.0)
    assert modes.taken_over(101.0, explained=False)


def test_expecting_modes_clears_what_was_unexpected() -> None:
    """On the way home LAND is as good as RTL, and a change requested before no longer counts."""
    modes = monitor(("LAND", True))
    modes.expect_change("AUTO")
    modes.expect("RTL", "LAND")
    assert modes.unexpected.count == 0
    modes.heartbeat("AUTO", True, 101.0)
    assert (modes.changed, modes.unexpected.count) == (False, 1)


def test_a_disarmed_vehicle_in_another_mode_may_have_rebooted() -> None:
    """Only its clock, later than 1.5 s after the first heartbeat, or 6 s without a clock exclude that."""
    modes = monitor(("STABILIZE", False), ("STABILIZE", False))
    assert not modes.taken_over(101.0, explained=False)
    modes.clock(50.0, 101.5)
    assert not modes.taken_over(106.0, explained=False)
    assert modes.taken_over(106.1, explained=False)
    modes.clock(51.0, 101.6)
    assert modes.taken_over(101.6, explained=False)


def test_two_heartbeats_and_the_clock_make_a_vehicle_certainly_disarmed() -> None:
    """One heartbeat is not enough, and neither is the time before a reboot is excluded."""
    modes = monitor(("AUTO", False))
    modes.clock(50.0, 101.6)
    assert not modes.certainly_disarmed(110.0)
    modes.heartbeat("AUTO", False, 102.0)
    assert modes.certainly_disarmed(102.0)
    modes = monitor(("AUTO", False), ("AUTO", False))
    assert not modes.certainly_disarmed(105.9)
    assert modes.certainly_disarmed(106.1)


def test_the_time_of_disarming_is_the_next_vehicle_time() -> None:
    """The first vehicle time after the first of two heartbeats, while the mode is the expected one."""
    modes = monitor(("AUTO", False))
    modes.clock(50.0, 100.1)
    modes.clock(50.2, 100.3)
    assert modes.disarmed_at_s is None
    modes.heartbeat("AUTO", False, 101.0)
    assert modes.disarmed_at_s == 50.0
    modes.heartbeat("STABILIZE", False, 102.0)
    assert modes.disarmed_at_s is None


def test_a_new_unexpected_heartbeat_starts_without_a_clock() -> None:
    """The clock has to advance again after each first one."""
    unexpected = UnexpectedHeartbeats()
    unexpected.heartbeat(True, 100.0)
    unexpected.clock(50.0, 102.0)
    assert unexpected.reboot_excluded(102.0)
    unexpected.heartbeat(False, 103.0)
    unexpected.heartbeat(True, 104.0)
    assert not unexpected.reboot_excluded(104.0)
    assert unexpected.time_s is None
