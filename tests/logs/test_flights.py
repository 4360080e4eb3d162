"""The flights of a track: armed stretches, or what moved, and choosing among them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.exceptions import LogError
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.logs.flights import find_flights, select
from flight_replay.logs.read_log import read_log
from flight_replay.logs.track import Armed, Track, track_from_columns
from tests.helpers.paths import other_log


def made(armed: list[int], speed_m_s: list[float] | None = None, boot: list[int] | None = None) -> Track:
    """A track at 2 Hz, 3 m east from fix to fix, that begins at 100 s."""
    n = len(armed)
    lat_deg, lon_deg = LocalFrame(47.0, 8.0).to_degrees(np.stack([np.zeros(n), 3.0 * np.arange(n)], axis=1))
    speed = np.zeros(n) if speed_m_s is None else np.array(speed_m_s, float)
    return track_from_columns(
        np.linspace(100, 100 + 0.5 * (n - 1), n),
        lat_deg,
        lon_deg,
        np.zeros(n),
        velocity_m_s=np.stack([speed, np.zeros(n), np.zeros(n)], axis=1),
        boot=np.zeros(n, np.int32) if boot is None else np.array(boot, np.int32),
        armed=np.array(armed, np.int8),
    )


def test_armed_stretches_are_flights_with_their_times_fixes_and_lengths() -> None:
    """Each run of armed fixes is numbered from 1, with seconds counted from the track's first fix."""
    flights = find_flights(made([0, 1, 1, 1, 0, 0, 1, 1, -1]))
    assert [(each.number, each.start_s, each.end_s, each.fixes) for each in flights] == [
        (1, 0.5, 1.5, 3),
        (2, 3.0, 3.5, 2),
    ]
    assert [each.length_m for each in flights] == pytest.approx([6.0, 3.0], abs=1e-4)
    assert [(each.first, each.last) for each in flights] == [(1, 3), (6, 7)]
    assert find_flights(made([1, 1, 0]))[0].length_m == pytest.approx(3.0, abs=1e-4)


def test_a_reboot_ends_a_flight() -> None:
    """Armed before and after a reboot are two flights."""
    assert [each.fixes for each in find_flights(made([1] * 6, boot=[0, 0, 1, 1, 1, 1]))] == [2, 4]


def test_a_log_that_tells_of_disarmed_motors_only_holds_no_flight() -> None:
    """Movement is asked about only where the log tells nothing of arming."""
    assert find_flights(made([0] * 40, [5.0] * 40)) == ()


def test_without_word_of_arming_moving_stretches_are_flights() -> None:
    """Pauses of up to 10 s belong to the flight; jerks shorter than 2 s are none."""
    speed = [0.1] * 30 + [4.0] * 10 + [0.0] * 12 + [2.0] * 10 + [0.0] * 30 + [3.0, 3.0] + [0.0] * 30
    flights = find_flights(made([Armed.UNKNOWN] * len(speed), speed))
    assert [(each.first, each.last) for each in flights] == [(30, 61)]
    assert find_flights(made([Armed.UNKNOWN] * 9)) == ()
    halves = find_flights(made([Armed.UNKNOWN] * 20, [4.0] * 20, [0] * 10 + [1] * 10))
    assert [each.fixes for each in halves] == [10, 10]


def test_a_boot_without_word_of_arming_is_asked_for_movement_beside_one_with() -> None:
    """A log of a boot that tells of nothing, joined to one that does, has the flights of both."""
    armed = [Armed.UNKNOWN] * 10 + [Armed.NO] * 5 + [Armed.YES] * 5
    track = made([int(each) for each in armed], [4.0] * 20, [0] * 10 + [1] * 10)
    assert [(each.first, each.last) for each in find_flights(track)] == [(0, 9), (15, 19)]


@pytest.mark.parametrize(("component_m_s", "moves"), [(0.3, True), (-0.3, True), (0.28, False)])
def test_movement_is_faster_than_half_a_metre_a_second_in_any_direction(
    component_m_s: float, moves: bool
) -> None:
    """North, east and up count together."""
    speed = np.full(20, component_m_s)
    track = replace(made([Armed.UNKNOWN] * 20), north_m_s=speed, east_m_s=speed, up_m_s=speed)
    assert len(find_flights(track)) == moves


@pytest.mark.parametrize(("fixes", "flights"), [(4, 0), (5, 1)])
def test_a_movement_of_two_seconds_is_a_flight(fixes: int, flights: int) -> None:
    """At 2 Hz five fixes last so long."""
    speed = [0.0] * 3 + [2.0] * fixes + [0.0] * 3
    assert len(find_flights(made([Armed.UNKNOWN] * len(speed), speed))) == flights


@pytest.mark.parametrize(("still", "flights"), [(19, 1), (20, 2)])
def test_a_pause_of_ten_seconds_ends_no_flight(still: int, flights: int) -> None:
    """From the last fix that moves to the next one."""
    speed = [2.0] * 9 + [0.0] * still + [2.0] * 9
    assert len(find_flights(made([Armed.UNKNOWN] * len(speed), speed))) == flights


@pytest.mark.parametrize(
    ("hover_s", "alt_m", "flights"),
    [(60.0, 20.0, 1), (300.0, 20.0, 1), (301.0, 20.0, 2), (60.0, 2.1, 1), (60.0, 1.9, 2), (60.0, np.nan, 2)],
)
def test_a_hover_ends_no_flight(hover_s: float, alt_m: float, flights: int) -> None:
    """Above home, for some minutes, a vehicle that stands still flies; lower, it may have landed."""
    still = round(2 * hover_s) - 1
    speed = [2.0] * 9 + [0.0] * still + [2.0] * 9
    track = made([Armed.UNKNOWN] * len(speed), speed)
    assert len(find_flights(replace(track, alt_m=np.full(len(speed), alt_m)))) == flights
    touching = np.full(len(speed), alt_m)
    touching[9 + still // 2] = 0.0
    assert len(find_flights(replace(track, alt_m=touching))) == 2


def test_velocities_that_are_not_known_are_no_movement() -> None:
    """A track without velocities and without arming holds no flight."""
    track = track_from_columns(np.arange(9.0), np.full(9, 47.0), np.full(9, 8.0), np.zeros(9))
    assert find_flights(track) == ()


def test_a_movement_whose_climb_is_not_known_is_one() -> None:
    """As of a GPX without elevations."""
    track = made([-1] * 12, [0.0] * 2 + [6.0] * 10)
    (flight,) = find_flights(replace(track, up_m_s=np.full(12, np.nan)))
    assert (flight.first, flight.last) == (2, 11)


def test_a_flight_is_chosen_by_its_number() -> None:
    """The fixes of the flight, and nothing else."""
    track = made([0, 1, 1, 1, 0, 0, 1, 1, 0])
    assert select(track, 2).time_s.tolist() == [103.0, 103.5]
    assert select(track) is track


def test_times_are_counted_from_the_first_fix_of_what_was_chosen() -> None:
    """--from and --to count from the flight's start, or from the track's."""
    track = made([0, 1, 1, 1, 0, 0, 1, 1, 0])
    assert select(track, from_s=1.0, to_s=2.0).time_s.tolist() == [101.0, 101.5, 102.0]
    assert select(track, 1, from_s=0.5).time_s.tolist() == [101.0, 101.5]
    assert select(track, 1, to_s=0.4).time_s.tolist() == [100.5]


@pytest.mark.parametrize(
    ("armed", "flight", "message"),
    [
        ([0, 1, 0, 1], 3, "no flight 3 in the log, choose --flight 1 to 2"),
        ([0, 1, 0], 0, "no flight 0 in the log, choose --flight 1$"),
        ([0, 0], 1, "which holds none; leave out --flight"),
    ],
)
def test_a_flight_that_is_not_there_is_told(armed: list[int], flight: int, message: str) -> None:
    """The error says which there are."""
    with pytest.raises(LogError, match=message):
        select(made(armed), flight)


def test_times_without_a_fix_are_told() -> None:
    """The error says between which times there are fixes."""
    with pytest.raises(LogError, match=r"choose from 0 to 1\.0 s"):
        select(made([0, 1, 0]), from_s=7.0)
    with pytest.raises(LogError, match=r"choose from 0 to 1\.0 s"):
        select(made([0, 1, 0]), to_s=-1.0)
    with pytest.raises(LogError, match=r"none from 0\.00 to 0\.50 s"):
        select(made([0, 1, 0]), from_s=0.2, to_s=0.3)
    gap = r"the log has none from 0\.50 to 1\.00 s, choose times beside that"
    with pytest.raises(LogError, match=gap):
        select(made([0, 1, 0]), from_s=0.6, to_s=0.7)


def test_the_dronekit_log_has_seven_flights() -> None:
    """Times, fixes and lengths of its armed stretches are those of the survey."""
    flights = find_flights(read_log(other_log("dronekit-flight.tlog")).track)
    assert [round(each.end_s - each.start_s) for each in flights] == [112, 142, 5, 4, 64, 29, 71]
    assert sum(each.fixes for each in flights) == 1169
    assert (flights[1].fixes, round(flights[1].length_m)) == (378, 483)
    assert sum(each.length_m for each in flights) == pytest.approx(1057, abs=3)
