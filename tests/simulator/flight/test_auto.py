"""AUTO flies the items of a mission as ArduCopter does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from math import degrees, hypot

import pytest

from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.mission.items import Command, Frame, Home, Mission, MissionItem, waypoint
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.auto import MissionRun
from flight_replay.simulator.flight.copter import Copter
from flight_replay.simulator.mission.local_items import (
    DO_JUMP,
    LocalItem,
    local_items,
)

LIMITS = Limits()
Spec = tuple[int, tuple[float, ...], tuple[float, float] | None, float | None]


def item_at(n: float, e: float, u: float | None = 20.0, *, hold_s: float = 0.0, spline: bool = False) -> Spec:
    return (Command.SPLINE_WAYPOINT if spline else Command.WAYPOINT, (hold_s,), (n, e), u)


def do(command: int, *params: float) -> Spec:
    return command, params, None, None


def items(*specs: Spec) -> list[LocalItem]:
    made = []
    for seq, (command, params, north_east, up) in enumerate(specs, 1):
        p1, p2, p3, p4 = (*params, 0.0, 0.0, 0.0, 0.0)[:4]
        made.append(LocalItem(seq, command, (p1, p2, p3, p4), north_east, up))
    return made


class Flown:
    """A mission flown to its end, or for some seconds."""

    def __init__(
        self, *specs: Spec, start: Vector = (0.0, 0.0, 20.0), start_seq: int = 1, seconds: float = 900.0
    ) -> None:
        self.copter = Copter(LIMITS, position_m=start)
        if start[2] == 0:
            self.copter.arm()
        self.run: MissionRun = self.copter.start_auto(items(*specs), start_seq)
        self.places: list[Vector] = []
        self.speeds: list[float] = []
        self.targets_up_m: list[float] = []
        self.yaws_rad: list[float] = []
        while not self.run.completed and self.copter.motors and self.copter.time_s < seconds:
            self.copter.step()
            self.places.append(self.copter.position_m)
            self.speeds.append(hypot(*self.copter.velocity_m_s))
            self.targets_up_m.append(self.copter.target_m[2])
            self.yaws_rad.append(self.copter.yaw_rad)

    @property
    def reached(self) -> dict[int, float]:
        return dict(self.run.reached)

    def nearest(self, n: float, e: float) -> float:
        return min(hypot(p[0] - n, p[1] - e) for p in self.places)

    def at(self, time_s: float) -> Vector:
        return self.places[round(time_s / self.copter.step_s) - 1]

    def heading_deg(self, time_s: float) -> float:
        return degrees(self.yaws_rad[round(time_s / self.copter.step_s) - 1])


def test_corners_are_cut_within_the_radius_and_the_end_is_a_stop() -> None:
    """A fast waypoint is passed by at speed inside WPNAV_RADIUS; the last one is flown to and held."""
    flown = Flown(item_at(40, 0), item_at(40, 40), item_at(0, 40))
    assert 0.3 < flown.nearest(40, 0) < 2.0
    corner = min(range(len(flown.places)), key=lambda i: hypot(flown.places[i][0] - 40, flown.places[i][1]))
    assert flown.speeds[corner] > 1.0
    assert flown.nearest(0, 40) < 0.7
    assert flown.speeds[-1] < 1.5
    assert list(flown.reached) == [1, 2, 3]


def test_a_larger_radius_cuts_more() -> None:
    """WPNAV_RADIUS 5 m passes farther from the corner than 2 m, and is quicker."""
    results = []
    for radius in (2.0, 5.0):
        copter = Copter(replace(LIMITS, wp_radius_m=radius), position_m=(0, 0, 20))
        run = copter.start_auto(items(item_at(40, 0), item_at(40, 40), item_at(0, 40)))
        nearest = 99.0
        while not run.completed:
            copter.step()
            nearest = min(nearest, hypot(copter.position_m[0] - 40, copter.position_m[1]))
        results.append((nearest, run.time_s))
    assert results[1][0] > results[0][0] + 0.3
    assert results[1][1] < results[0][1]


@pytest.mark.parametrize("spline", [False, True])
def test_holds_last_whole_seconds_at_the_waypoint(spline: bool) -> None:
    """A delay of 3.9 s holds for 3 s, after a stop within the radius."""
    held = Flown(item_at(30, 0, hold_s=3.9, spline=spline), item_at(60, 0))
    passed = Flown(item_at(30, 0, hold_s=1.0, spline=spline), item_at(60, 0))
    assert held.reached[1] - passed.reached[1] == pytest.approx(2.0, abs=0.03)
    assert held.nearest(30, 0) < 0.1
    assert hypot(held.at(held.reached[1])[0] - 30, held.at(held.reached[1])[1]) < 0.6


def test_splines_bulge_out_of_a_square() -> None:
    """Spline legs around a square leave it, by 5 m on sides of 20 m in the inner legs."""
    flown = Flown(
        item_at(20, 0, spline=True),
        item_at(20, 20, spline=True),
        item_at(0, 20, spline=True),
        item_at(0, 0, spline=True),
    )
    assert max(n for n, _, _ in flown.places) > 23.0
    assert flown.nearest(20, 20) < 1.0


def test_straight_and_spline_legs_join() -> None:
    """A mixed mission flies through every item in order without stopping at fast ones."""
    flown = Flown(
        item_at(30, 0),
        item_at(50, 20, spline=True),
        item_at(40, 50),
        item_at(0, 60, spline=True),
        item_at(-20, 30, spline=True),
        item_at(-20, 0),
    )
    assert list(flown.reached) == [1, 2, 3, 4, 5, 6]
    begin = flown.reached[1] - 1.0
    between = flown.speeds[round(begin / 0.02) : round((flown.reached[5] + 1.0) / 0.02)]
    assert min(between) > 0.5
    for n, e in ((50, 20), (40, 50), (0, 60), (-20, 30)):
        assert flown.nearest(n, e) < 2.2


def test_speed_changes_hold_from_the_waypoint_before_them() -> None:
    """DO_CHANGE_SPEED limits the legs after it: level, up and down each by their kind."""
    flown = Flown(
        item_at(60, 0, hold_s=1.0),
        do(Command.CHANGE_SPEED, 1, 3.0),
        item_at(120, 0, hold_s=1.0),
        do(Command.CHANGE_SPEED, 2, 0.8),
        item_at(120, 2, 40.0, hold_s=1.0),
        do(Command.CHANGE_SPEED, 3, 0.6),
        item_at(120, 4, 30.0),
        do(Command.CHANGE_SPEED, 1, -1.0),
        item_at(150, 4, 30.0),
    )
    times = flown.reached
    assert max(flown.speeds[: round(times[1] / 0.02)]) > 5.0
    assert max(flown.speeds[round((times[1] + 1) / 0.02) : round(times[3] / 0.02)]) < 3.3
    climb = flown.at(times[5])[2] - flown.at(times[3])[2]
    assert climb / (times[5] - times[3]) < 0.9
    sink = flown.at(times[5])[2] - flown.at(times[7])[2]
    assert sink / (times[7] - times[5]) < 0.7
    assert [seq for seq, _ in flown.run.reached] == list(range(1, 10))


def test_a_lower_speed_is_taken_up_on_the_way() -> None:
    """A change that comes while the next leg has begun already still slows that leg."""
    flown = Flown(item_at(20, 0), item_at(40, 5), do(Command.CHANGE_SPEED, 1, 2.0), item_at(200, 5))
    late = [s for p, s in zip(flown.places, flown.speeds, strict=True) if 120 < p[0] < 180]
    assert max(late) < 2.3


@pytest.mark.parametrize(("behind_another", "seconds"), [(False, 10.5), (True, 12.3)])
def test_a_higher_speed_behind_another_item_comes_on_the_way(behind_another: bool, seconds: float) -> None:
    """A leg of 30 m in ArduCopter 4.6: gained is the speed from before at first, then that of the leg."""
    flown = Flown(
        do(Command.CHANGE_SPEED, 1, 2.7),
        item_at(5, 0, hold_s=1.0),
        *[do(Command.CHANGE_SPEED, 2, 2.5)] * behind_another,
        do(Command.CHANGE_SPEED, 1, 6.5),
        item_at(35, 0),
    )
    times = list(flown.reached.values())
    assert times[-1] - flown.reached[2] == pytest.approx(seconds, abs=0.3)


def test_zero_locations_and_altitudes_mean_here_and_the_same() -> None:
    """Without a location an item is where the last one was, without an altitude at the same height."""
    flown = Flown(
        item_at(30, 0, 25.0), item_at(30, 30, None, hold_s=1.0), (Command.WAYPOINT, (0.0,), None, 40.0)
    )
    assert flown.at(flown.reached[2])[2] == pytest.approx(25.0, abs=0.3)
    assert flown.places[-1] == pytest.approx((30.0, 30.0, 40.0), abs=2.0)


def test_loitering_for_a_time_and_for_ever() -> None:
    """LOITER_TIME stays its seconds; LOITER_UNLIM never ends, and says so."""
    flown = Flown(
        (Command.LOITER_TIME, (5.0,), (20, 0), 20.0),
        (Command.LOITER_UNLIMITED, (), (20, 30), None),
        seconds=60.0,
    )
    assert list(flown.reached) == [1]
    assert not flown.run.completed
    assert flown.run.loitering
    assert flown.copter.position_m == pytest.approx((20.0, 30.0, 20.0), abs=0.2)
    plain = Flown(item_at(20, 0, hold_s=1.0), item_at(20, 30))
    assert flown.reached[1] - plain.reached[1] == pytest.approx(4.0, abs=0.5)


@pytest.mark.parametrize("radius", [12.0, -12.0], ids=["clockwise", "counterclockwise"])
def test_circles_are_flown_the_number_of_times_asked_for(radius: float) -> None:
    """LOITER_TURNS goes around its centre at the radius, in the direction of its sign."""
    flown = Flown(item_at(40, 0), (Command.LOITER_TURNS, (2.0, 0.0, radius), (40, 30), 20.0), item_at(40, 0))
    on_circle = [p for p in flown.places if abs(hypot(p[0] - 40, p[1] - 30) - 12.0) < 1.0]
    assert len(on_circle) > 1000
    turning = sum((a[0] - 40) * (b[1] - 30) - (a[1] - 30) * (b[0] - 40) for a, b in pairwise(on_circle))
    # Twice the area swept, twice around: 4 pi r².
    assert turning == pytest.approx(4 * 3.14159 * 144 * (1 if radius > 0 else -1), rel=0.15)


def test_a_circle_is_begun_at_once_on_its_edge() -> None:
    """Within 3 m of the edge there is no leg to it; radius 0 takes CIRCLE_RADIUS."""
    flown = Flown((Command.LOITER_TURNS, (1.0,), (10, 0), 20.0))
    radii = [hypot(p[0] - 10, p[1]) for p in flown.places]
    assert max(abs(r - LIMITS.circle_radius_m) for r in radii) < 1.5
    assert flown.run.completed


def test_a_circle_without_a_radius_is_as_wide_as_the_one_before() -> None:
    """Radius 0 after a circle of 16 m is 16 m, as in ArduCopter 4.6."""
    wide = (Command.LOITER_TURNS, (1.0, 0.0, 16.0), (16, 0), 20.0)
    flown = Flown(wide, (Command.LOITER_TURNS, (1.0,), (16, 0), 20.0))
    assert flown.reached[2] - flown.reached[1] == pytest.approx(flown.reached[1], abs=3.0)
    assert max(abs(hypot(p[0] - 16, p[1]) - 16.0) for p in flown.places) < 1.5


def test_parameters_are_flown_as_they_are_stored() -> None:
    """Of one and a half turns ArduPilot keeps one (AP_Mission)."""
    item = MissionItem(Command.LOITER_TURNS, Frame.RELATIVE, (1.5, 0.0, 300.9, 0.0), 47.0, 8.0, 20.0)
    assert _local(Mission((item,), Home(47.0, 8.0, 400.0)))[0].params == (1.0, 0.0, 300.0, 0.0)


def test_delays_wait_where_the_vehicle_is() -> None:
    """NAV_DELAY holds its seconds between two waypoints, the first of which is a stop."""
    flown = Flown(item_at(20, 0), do(Command.DELAY, 4.0), item_at(40, 0))
    assert flown.reached[2] - flown.reached[1] == pytest.approx(4.0, abs=0.05)
    assert flown.at(flown.reached[2]) == pytest.approx((20.0, 0.0, 20.0), abs=0.3)


def test_jumps_are_counted() -> None:
    """DO_JUMP goes back its number of times, then on; a jump nowhere ends the mission."""
    flown = Flown(item_at(15, 0), item_at(15, 15), do(DO_JUMP, 1, 2), item_at(0, 0))
    assert [seq for seq, _ in flown.run.reached] == [1, 2, 1, 2, 1, 2, 4]
    assert [seq for seq, _ in Flown(item_at(15, 0), do(DO_JUMP, 99, 1), item_at(5, 0)).run.reached] == [1]
    endless = Flown(item_at(5, 0), do(DO_JUMP, 1, -1), seconds=60.0)
    assert not endless.run.completed
    assert len(endless.run.reached) > 3


def test_conditions_hold_up_what_comes_after_them() -> None:
    """DO items behind a condition wait for time, distance or heading."""
    waited = Flown(
        item_at(60, 0), do(Command.CONDITION_DELAY, 3.0), do(Command.CHANGE_SPEED, 1, 2.0), item_at(140, 0)
    )
    begin = waited.reached[1]
    assert waited.reached[2] - begin == pytest.approx(3.0, abs=0.1)
    near = Flown(
        item_at(60, 0),
        do(Command.CONDITION_DISTANCE, 30.0),
        do(Command.CHANGE_SPEED, 1, 2.0),
        item_at(140, 0),
    )
    assert near.at(near.reached[2])[0] == pytest.approx(110.0, abs=1.0)
    turned = Flown(
        item_at(60, 0),
        do(Command.CONDITION_YAW, 90.0, 30.0, 1.0, 0.0),
        do(Command.CHANGE_SPEED, 1, 4.0),
        item_at(140, 0),
    )
    assert turned.reached[2] - turned.reached[1] == pytest.approx(3.0, abs=1.5)


def roi(n: float, e: float) -> Spec:
    return Command.SET_ROI, (), (n, e), 20.0


def test_a_position_is_faced_until_something_else_is_asked_for() -> None:
    """DO_SET_ROI outlasts its leg, also where the next one changes speed first; a turn ends it."""
    flown = Flown(
        roi(40.0, 1000.0),
        item_at(40, 0),
        do(Command.CHANGE_SPEED, 1, 4.0),
        item_at(80, 0),
        do(Command.CONDITION_YAW, 180.0, 60.0),
        item_at(120, 0),
        do(Command.CHANGE_SPEED, 1, 5.0),
        item_at(160, 0),
    )
    assert flown.heading_deg(5.0) == pytest.approx(90.0, abs=3.0)
    assert flown.heading_deg(flown.reached[4] - 0.5) == pytest.approx(92.0, abs=3.0)
    assert abs(flown.heading_deg(flown.reached[6] - 0.5)) == pytest.approx(180.0, abs=2.0)
    assert flown.heading_deg(flown.reached[8] - 0.5) == pytest.approx(0.0, abs=2.0)


def test_a_turn_goes_on_from_the_position_that_is_faced() -> None:
    """Behind a speed change too: at 20 degrees a second from east, not from the path's heading."""
    flown = Flown(
        roi(0.0, 1000.0),
        item_at(40, 0),
        do(Command.CHANGE_SPEED, 1, 4.0),
        do(Command.CONDITION_YAW, 180.0, 20.0),
        item_at(80, 0),
    )
    assert flown.heading_deg(flown.reached[2] + 2.0) == pytest.approx(125.0, abs=10.0)


def test_without_a_position_nothing_is_faced() -> None:
    """DO_SET_ROI at 0, 0 looks along the path again; circles too are flown with the nose where it is told."""
    flown = Flown(roi(0.0, 1000.0), item_at(40, 0), do(Command.SET_ROI), item_at(80, 0))
    assert flown.heading_deg(flown.reached[2] - 1.0) == pytest.approx(90.0, abs=4.0)
    assert flown.heading_deg(flown.reached[4] - 0.5) == pytest.approx(0.0, abs=2.0)
    circle = (Command.LOITER_TURNS, (1.0, 0.0, 10.0), (0.0, 0.0), 20.0)
    flown = Flown(roi(1e5, 0.0), circle)
    assert flown.heading_deg(20.0) == pytest.approx(0.0, abs=2.0)


def test_a_mission_begins_without_a_position_of_the_last_one() -> None:
    """ModeAuto::init: its first leg looks along the path."""
    copter = Copter(LIMITS, position_m=(0.0, 0.0, 20.0))
    copter.start_auto(items(roi(0.0, 1000.0), item_at(60, 0)))
    for _ in range(round(5.0 / copter.step_s)):
        copter.step()
    assert degrees(copter.yaw_rad) == pytest.approx(90.0, abs=3.0)
    copter.start_auto(items(item_at(120, 0)))
    for _ in range(round(5.0 / copter.step_s)):
        copter.step()
    assert degrees(copter.yaw_rad) == pytest.approx(0.0, abs=2.0)


def test_take_off_return_and_landing_in_a_mission() -> None:
    """From the ground: NAV_TAKEOFF climbs, RTL comes home and lands, and the motors stop."""
    flown = Flown(
        (Command.TAKEOFF, (), None, 12.0),
        item_at(30, 0, 12.0),
        do(Command.RETURN_TO_LAUNCH),
        start=(0.0, 0.0, 0.0),
    )
    assert not flown.copter.motors or flown.copter.landed
    assert list(flown.reached) == [1, 2, 3]
    assert flown.places[-1] == pytest.approx((0.0, 0.0, 0.0), abs=0.1)
    assert max(p[2] for p in flown.places) == pytest.approx(15.0, abs=0.3)


def test_heights_of_another_kind_are_a_stop() -> None:
    """Between heights above home and above terrain no corner is cut; without, it is."""
    corner, end = items(item_at(40, 0), item_at(40, 40))
    for above_terrain in (False, True):
        copter = Copter(LIMITS, position_m=(0.0, 0.0, 20.0))
        run = copter.start_auto([corner, replace(end, above_terrain=above_terrain)])
        while len(run.reached) < 1:
            copter.step()
        assert (hypot(*copter.velocity_m_s) < 1.0) is above_terrain


def test_commands_for_planes_that_hover_are_a_copters() -> None:
    """NAV_VTOL_LAND is a landing."""
    item = MissionItem(85, Frame.RELATIVE, (0.0,) * 4, 47.0, 8.0, 0.0)
    assert _local(Mission((item,), Home(47.0, 8.0, 400.0)))[0].command == Command.LAND


def test_the_leg_after_a_take_off_begins_where_the_copter_could_stop() -> None:
    """Some decimetres above the take-off's height, as in ArduCopter 4.6, and not at it."""
    flown = Flown((Command.TAKEOFF, (), None, 25.0), item_at(40, 0, 20.0), start=(0.0, 0.0, 10.0))
    assert 25.1 < max(flown.targets_up_m) < 25.3


def test_landing_at_a_location_and_here() -> None:
    """LAND flies to its location at its altitude, then down; without a location it lands here."""
    there = Flown(item_at(20, 0), (Command.LAND, (), (20, 25), 0.0))
    assert there.places[-1] == pytest.approx((20.0, 25.0, 0.0), abs=0.3)
    assert not there.copter.motors
    assert min(u for n, e, u in there.places if hypot(n - 20, e - 25) > 3.0) > 18.0
    here = Flown(item_at(20, 0), do(Command.LAND))
    assert here.places[-1] == pytest.approx((20.0, 0.0, 0.0), abs=0.3)
    assert list(here.reached) == [1]


def test_a_mission_may_begin_in_the_middle() -> None:
    """MISSION_SET_CURRENT: what comes before is left out."""
    flown = Flown(item_at(0, 80), item_at(20, 0), item_at(40, 0), start_seq=2)
    assert list(flown.reached) == [2, 3]
    assert flown.run.destination_m == pytest.approx((40.0, 0.0, 20.0), abs=0.7)


def test_nothing_to_fly_is_a_hover() -> None:
    """An empty mission is over at once, and the copter stays."""
    flown = Flown()
    assert flown.run.completed
    copter = flown.copter
    while copter.time_s < 10.0:
        copter.step()
    assert copter.position_m == pytest.approx((0.0, 0.0, 20.0), abs=0.05)


def test_coinciding_waypoints_are_passed() -> None:
    """Items at the same location, straight or spline, cost no time."""
    flown = Flown(
        item_at(20, 0),
        item_at(20, 0),
        item_at(20, 0, spline=True),
        item_at(20, 0, spline=True),
        item_at(40, 0),
    )
    assert flown.run.completed
    assert list(flown.reached) == [1, 2, 3, 4, 5]


def _local(mission: Mission) -> Sequence[LocalItem]:
    home = mission.home or Home(0, 0, 0)
    return local_items(mission, FlatFrame(home.lat_deg, home.lon_deg), home.amsl_m)


def test_items_become_local_by_their_frames() -> None:
    """Relative and terrain heights count from home, absolute ones from sea level; zeros stay open."""
    home = Home(47.0, 8.0, 400.0)
    absolute = MissionItem(Command.WAYPOINT, Frame.ABSOLUTE, (0.0,) * 4, 47.001, 8.0, 430.0)
    nowhere = MissionItem(Command.WAYPOINT, Frame.RELATIVE, (0.0,) * 4, 0.0, 0.0, 0.0)
    local = _local(Mission((waypoint(47.0, 8.001, 30.0), absolute, nowhere), home))
    assert local[0].up_m == local[1].up_m == 30.0
    assert local[0].north_east_m == pytest.approx((0.0, 75.9), abs=0.1)
    assert local[2].position((1.0, 2.0, 3.0)) == (1.0, 2.0, 3.0)
    assert _local(Mission((), home)) == ()


def heading_after_a_second(*before: Spec) -> float:
    """The heading, degrees, one second into a leg north with items ``before`` it, of a copter facing east."""
    flown = Flown(
        item_at(30, 0),
        do(Command.CONDITION_YAW, 90.0),
        item_at(90, 0),
        *before,
        item_at(150, 0),
        seconds=120.0,
    )
    begin = flown.reached[3]
    copter = Copter(LIMITS, position_m=(0.0, 0.0, 20.0))
    copter.start_auto(
        items(item_at(30, 0), do(Command.CONDITION_YAW, 90.0), item_at(90, 0), *before, item_at(150, 0))
    )
    while copter.time_s < begin + 1.0:
        copter.step()
    return degrees(copter.yaw_rad)


def test_a_heading_holds_until_the_next_leg() -> None:
    """Without an item the next leg is flown ahead again; with one that comes first the turn goes on."""
    assert heading_after_a_second() < 45
    assert heading_after_a_second(do(Command.CONDITION_YAW, 90.0)) == pytest.approx(90.0, abs=1.0)


def test_a_turn_behind_another_item_begins_on_the_path() -> None:
    """AP_Mission starts it one update after the leg, whose heading is the target by then."""
    late = heading_after_a_second(do(Command.CHANGE_SPEED, 1, 9.0), do(Command.CONDITION_YAW, 90.0))
    assert late < 85
