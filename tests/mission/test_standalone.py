"""standalone.py: a saved mission takes off and comes home by itself."""

from flight_replay.mission.items import Command, Home, Mission, change_speed, speed_from_the_start, waypoint
from flight_replay.mission.standalone import standalone

ROUTE = Mission((change_speed(3.0), waypoint(47.4, 8.5, 30.0)), Home(47.39, 8.49, 400.0))


def test_takeoff_comes_first_and_return_last() -> None:
    """Around the same items, under the same home."""
    whole = standalone(ROUTE, 25.0)
    takeoff, *items, come_home = whole.items
    assert (takeoff.command, takeoff.alt_m) == (Command.TAKEOFF, 25.0)
    assert (takeoff.lat_deg, takeoff.lon_deg) == (47.39, 8.49)
    assert tuple(items) == ROUTE.items
    assert come_home.command == Command.RETURN_TO_LAUNCH
    assert whole.home == ROUTE.home


def test_after_the_takeoff_no_wait_is_needed() -> None:
    """Stations would draw it at latitude and longitude 0."""
    begun = Mission((*speed_from_the_start(3.0), ROUTE.items[1]), ROUTE.home)
    assert standalone(begun, 25.0) == standalone(ROUTE, 25.0)


def test_without_home_it_is_drawn_at_the_first_waypoint() -> None:
    """Not at latitude and longitude 0."""
    takeoff = standalone(Mission(ROUTE.items), 25.0).items[0]
    assert (takeoff.lat_deg, takeoff.lon_deg) == (47.4, 8.5)
