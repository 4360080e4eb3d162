"""The planned path: straight legs, ArduCopter's spline legs, holds, and which item each piece leads to."""

from typing import Any

import numpy as np
import pytest

from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.geometry.polyline import nearest_on_segments
from flight_replay.mission.items import (
    Command,
    Frame,
    Mission,
    MissionItem,
    change_speed,
    speed_from_the_start,
    waypoint,
)
from flight_replay.mission.path import (
    Destination,
    destinations,
    leg_tangents,
    path_through,
    planned_path,
)

FRAME = LocalFrame(47.0, 8.0)


def at(north_m: float, east_m: float, alt_m: float = 30.0, **options: Any) -> MissionItem:
    """A waypoint at a place in metres."""
    lat, lon = FRAME.to_degrees([north_m, east_m])
    return waypoint(float(lat), float(lon), alt_m, **options)


def vectors(
    route: list[Destination], first: tuple[float, float, float] = (0, 0, 0)
) -> list[tuple[list[float], list[float]]]:
    """Level tangents of every leg."""
    corners = np.array([first, *(destination.position_m for destination in route)])
    leaving, arriving = leg_tangents(route, corners)
    return list(zip(leaving[:, :2].tolist(), arriving[:, :2].tolist(), strict=True))


def stop(north_m: float, east_m: float, **options: Any) -> Destination:
    """A place of a route in metres."""
    return Destination(1, np.array([north_m, east_m, 0.0]), **options)


def test_straight_legs_are_lines_through_the_places_and_carry_their_sequence_numbers() -> None:
    """A mission of straight waypoints gives exactly its places, each with its item's number on board."""
    path = planned_path(Mission((at(0, 0), change_speed(3), at(0, 40), at(30, 40, hold_s=5))), FRAME)
    assert np.allclose(path.north_east_m, [[0, 0], [0, 0], [0, 40], [30, 40]], atol=1e-6)
    assert path.seq.tolist() == [1, 1, 3, 4]
    assert path.length_m == pytest.approx(70, abs=1e-6)


def test_without_places_there_is_no_path() -> None:
    """A mission of speed changes alone gives an empty path."""
    assert planned_path(Mission((change_speed(3),)), FRAME).north_east_m.shape == (0, 2)


def test_a_square_of_splines_bulges_as_arducopters_does() -> None:
    """The curve of 20 m square corners leaves the chord by 5 m, twice what Catmull-Rom's would."""
    route = [
        stop(0, 0, spline=True),
        stop(0, 20, spline=True),
        stop(20, 20, spline=True),
        stop(20, 0, spline=True),
    ]
    path = path_through([stop(20, 0), *route, stop(0, 0, spline=True)])
    side = path.north_east_m[(path.north_east_m[:, 1] > 5) & (path.north_east_m[:, 1] < 15)]
    assert side[:, 0].min() == pytest.approx(-5, abs=0.01)


def test_a_spline_leaves_towards_what_follows() -> None:
    """The destination tangent is next minus origin before a spline, next minus destination before a line."""
    assert vectors([stop(0, 10, spline=True), stop(10, 10, spline=True)])[0][1] == [10, 10]
    assert vectors([stop(0, 10, spline=True), stop(10, 10)])[0][1] == [10, 0]


def test_a_spline_comes_from_where_the_last_leg_went() -> None:
    """The origin tangent is the straight leg's vector, or the last spline's own destination tangent."""
    assert vectors([stop(0, 10), stop(10, 10, spline=True)])[1][0] == [0, 10]
    assert vectors([stop(0, 10, spline=True), stop(10, 10, spline=True)])[1][0] == [10, 10]


@pytest.mark.parametrize("spline", [False, True])
def test_a_halt_has_no_tangent(spline: bool) -> None:
    """Where the vehicle halts, and at the route's end, the curve starts and ends without a tangent."""
    first = stop(0, 10, spline=spline, halts=True)
    legs = vectors([first, stop(10, 10, spline=True)])
    assert legs[0][1] == legs[1][0] == legs[1][1] == [0, 0]


def test_curves_are_drawn_within_the_tolerance() -> None:
    """The middle of every drawn line lies within the tolerance of the curve; straight legs are one line."""
    route = [stop(0, 0), stop(20, 5, spline=True), stop(20, 40, spline=True), stop(60, 40)]
    drawn, fine = path_through(route).north_east_m, path_through(route, tolerance_m=1e-5).north_east_m
    middles = (drawn[1:] + drawn[:-1])[:, None] / 2
    apart = nearest_on_segments(middles, fine[:-1], np.diff(fine, axis=0))[1].min(axis=1)
    assert 0.0005 < apart.max() < 0.001 + 1e-5
    assert drawn[-2:].tolist() == [[20, 40], [60, 40]]


def test_equal_places_make_a_leg_without_length() -> None:
    """A spline to where the vehicle is stays there and leaves without a tangent, as ArduCopter does."""
    assert vectors([stop(0, 0, spline=True), stop(0, 10, spline=True)])[0][1] == [0, 0]
    assert path_through([stop(0, 0), stop(0, 0, spline=True)]).length_m == 0


def test_zeros_mean_here() -> None:
    """Latitude and longitude 0 are the place before, and height 0 keeps the height."""
    items = (at(10, 20, 25.0), MissionItem(Command.WAYPOINT, Frame.RELATIVE, (0, 0, 0, 0), 0, 0, 0))
    found = destinations(items, FRAME)
    assert np.allclose(found[0].position_m, found[1].position_m)


def test_a_wait_here_leads_nowhere() -> None:
    """The path of a mission that begins with one begins at the first place that is known."""
    items = (*speed_from_the_start(2.0), at(10, 0), at(20, 0))
    assert planned_path(Mission(items), FRAME).seq.tolist() == [3, 3, 4]


@pytest.mark.parametrize("command", [Command.RETURN_TO_LAUNCH, Command.LAND, Command.LOITER_TURNS])
def test_the_vehicle_halts_before_commands_that_are_no_waypoint(command: Command) -> None:
    """Before a return, a landing and turns the waypoint is a halt, before a plain loiter it is not."""
    ending = MissionItem(command, Frame.RELATIVE, (0, 0, 0, 0), 0, 0, 0)
    assert destinations((at(0, 10), ending), FRAME)[0].halts
    loiter = MissionItem(Command.LOITER_UNLIMITED, Frame.RELATIVE, (0, 0, 0, 0), 0, 0, 0)
    assert [found.halts for found in destinations((at(0, 10), loiter), FRAME)] == [False, True]
