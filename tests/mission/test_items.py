"""A mission numbers its items as the vehicle does."""

from flight_replay.mission.items import Command, Frame, Home, Mission, change_speed, waypoint


def test_items_are_numbered_from_one() -> None:
    """Home has number 0 on board, so the first item is number 1, speed changes counted."""
    mission = Mission((waypoint(1, 2, 3), change_speed(4), waypoint(5, 6, 7, hold_s=2, spline=True)))
    assert [seq for seq, _ in mission.waypoints] == [1, 3]
    assert [item.is_spline for _, item in mission.waypoints] == [False, True]
    assert [item.hold_s for item in mission.items] == [0, 0, 2]


def test_change_speed_is_of_ground_speed() -> None:
    """DO_CHANGE_SPEED says speed type 1 in param1, m/s in param2."""
    item = change_speed(4.5)
    assert (item.command, item.frame, item.params[:2]) == (Command.CHANGE_SPEED, Frame.MISSION, (1.0, 4.5))
    assert not item.is_waypoint


def test_home_is_no_item() -> None:
    """Giving a mission a home leaves its items alone."""
    mission = Mission((waypoint(1, 2, 3),)).with_home(Home(1, 2, 488))
    assert mission.home == Home(1, 2, 488)
    assert len(mission.items) == 1
