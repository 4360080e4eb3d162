"""Which recorded positions are implausible, and the reason that is given."""

from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.logs.plausibility import RecordedPositions, Rejection, find_implausible

FRAME = LocalFrame(47.4, 8.5)
NONE, EMPTY, NO_FIX, NEAR_ZERO, OUTSIDE, JUMP = Rejection


class Flight:
    """Positions in metres north and east of a place, 4 Hz unless told otherwise."""

    def __init__(self, frame: LocalFrame = FRAME) -> None:
        self.frame = frame
        self.boot, self.time_s = 0, 20.0
        self.rows: list[tuple[float, ...]] = []

    def to(
        self, north_m: float, east_m: float = 0.0, after_s: float = 0.25, speed_m_s: float = 0.0
    ) -> Flight:
        """Append a position ``after_s`` seconds after the last one."""
        self.time_s += after_s
        lat_deg, lon_deg = self.frame.to_degrees([north_m, east_m])
        return self.at(float(lat_deg), (float(lon_deg) + 180) % 360 - 180, speed_m_s)

    def at(
        self, lat_deg: float, lon_deg: float, speed_m_s: float = 0.0, lacks_3d_fix: bool = False
    ) -> Flight:
        """Append a position at the time of the last one."""
        self.rows.append((self.time_s, lat_deg, lon_deg, speed_m_s, self.boot, lacks_3d_fix))
        return self

    def along(
        self, fixes: int, start_m: float = 0.0, speed_m_s: float = 5.0, reported: bool = True
    ) -> Flight:
        """Append a straight flight east."""
        for fix in range(fixes):
            self.to(0.0, start_m + 0.25 * speed_m_s * fix, speed_m_s=speed_m_s if reported else 0.0)
        return self

    def reboot(self) -> Flight:
        """Begin another boot."""
        self.boot += 1
        return self

    @property
    def positions(self) -> RecordedPositions:
        """All positions as columns."""
        time_s, lat_deg, lon_deg, speed_m_s, boot, lacks = np.array(self.rows).T
        return RecordedPositions(time_s, lat_deg, lon_deg, speed_m_s.take, boot.astype(np.int32), lacks > 0)

    def found(self) -> list[int]:
        """The rejection of each position."""
        found: list[int] = find_implausible(self.positions).tolist()
        return found

    def count(self, reason: Rejection = JUMP) -> int:
        """How many are rejected for that reason, and no other."""
        found = self.found()
        assert set(found) <= {NONE, reason}
        return found.count(reason)


def test_an_ordinary_flight_is_plausible() -> None:
    """Nothing is rejected of steps that the reported velocity explains."""
    assert Flight().along(100).count() == 0


@pytest.mark.parametrize("speed_m_s", [25.0, 60.0, 90.0, 300.0])
def test_a_fast_flight_that_reports_its_speed_is_plausible(speed_m_s: float) -> None:
    """A racer's or a plane's fixes are far apart, and its velocity says so."""
    assert Flight().along(60, speed_m_s=speed_m_s).count() == 0


@pytest.mark.parametrize(("speed_m_s", "rejected"), [(60.0, 0), (130.0, 0), (150.0, 10)])
def test_without_a_reported_speed_the_fastest_multicopter_is_assumed(speed_m_s: float, rejected: int) -> None:
    """Steps of 60 m/s and the slack of 20 m are plausible: 35 m in 0.25 s; more is a jump at every fix."""
    assert Flight().along(11, speed_m_s=speed_m_s, reported=False).count() == rejected


def test_a_speed_that_is_not_known_is_that_of_the_fastest_multicopter() -> None:
    """Velocities that are not numbers, as of formats that have none, neither excuse nor condemn."""
    assert Flight().to(0).to(34.0, speed_m_s=np.nan).count() == 0
    assert Flight().to(0).to(36.0, speed_m_s=np.nan).count() == 1


@pytest.mark.parametrize(
    ("apart_m", "speeds_m_s", "rejected"),
    [
        (134.0, (0.0, 0.0), 0),
        (146.0, (0.0, 0.0), 1),
        (310.0, (100.0, 0.0), 0),
        (310.0, (0.0, 100.0), 0),
        (330.0, (100.0, 100.0), 1),
        (190.0, (60.0, 0.0), 0),
        (210.0, (60.0, 60.0), 1),
    ],
)
def test_a_move_is_possible_at_one_and_a_half_times_the_higher_speed_reported(
    apart_m: float, speeds_m_s: tuple[float, float], rejected: int
) -> None:
    """In 2 s it may have gone 20 m, and 60 m/s, or 1.5 times what it reported at either end."""
    flight = Flight().to(0.0, speed_m_s=speeds_m_s[0]).to(apart_m, after_s=2.0, speed_m_s=speeds_m_s[1])
    assert flight.count() == rejected


@pytest.mark.parametrize("direction", [(1, 0), (-1, 0), (0, 1), (0, -1)])
@pytest.mark.parametrize(("step_m", "rejected"), [(19.0, 0), (21.0, 1)])
def test_estimators_may_correct_themselves_by_20_m_at_once(
    direction: tuple[int, int], step_m: float, rejected: int
) -> None:
    """Whichever way; two positions at the same time need no speed to be compared."""
    north, east = direction
    assert Flight().to(0).to(0).to(step_m * north, step_m * east, after_s=0.0).count() == rejected


def test_a_gap_in_the_log_is_plausible() -> None:
    """A flight at 40 m/s goes on 104 m farther after 2.6 s without a record, and 1.2 km after a minute."""
    flight = Flight().along(20, speed_m_s=40.0).to(0, 19 * 10 + 104, after_s=2.6, speed_m_s=40.0)
    assert flight.to(0, 1_500, after_s=60.0).count() == 0


@pytest.mark.parametrize("lat_deg", [0.5, -16.0, 68.0])
def test_a_flight_across_the_antimeridian_is_plausible(lat_deg: float) -> None:
    """Longitude leaps from 180 to -180 degrees while the vehicle does not."""
    flight = Flight(LocalFrame(lat_deg, 179.9999)).along(80)
    assert np.ptp(flight.positions.lon_deg) > 359
    assert flight.count() == 0


def test_an_outlier_is_rejected() -> None:
    """A few positions 500 m away between good ones go, and no others."""
    flight = Flight().along(30)
    for _ in range(3):
        flight.to(500.0, 30.0)
    assert flight.along(30, 38.0).found() == [NONE] * 30 + [JUMP] * 3 + [NONE] * 30


def test_a_false_start_before_a_jump_is_rejected() -> None:
    """A cold receiver's first positions, 226 m away, go; the flight stays."""
    flight = Flight()
    for fix in range(25):
        flight.to(226.0 - fix, 0.0)
    assert flight.along(100).found() == [JUMP] * 25 + [NONE] * 100


def test_a_false_end_behind_a_jump_is_rejected() -> None:
    """What has fewer positions goes, be it later or earlier; of equal runs the first stays."""
    assert Flight().along(10).along(9, 5_000).found() == [NONE] * 10 + [JUMP] * 9
    assert Flight().along(9).along(10, 5_000).found() == [JUMP] * 9 + [NONE] * 10
    assert Flight().along(9).along(9, 5_000).found() == [NONE] * 9 + [JUMP] * 9


def test_two_places_in_turns_leave_the_one_told_most() -> None:
    """Of positions that flicker between two places 5 km apart, only those of one are plausible."""
    flight = Flight().along(10)
    for fix in range(300):
        flight.to(5_000.0 if fix % 3 == 2 else 0.0, 20.0)
    assert flight.found() == [NONE] * 10 + [JUMP if fix % 3 == 2 else NONE for fix in range(300)]


@pytest.mark.parametrize("outliers", [1, 7, 8, 9, 30])
def test_the_flight_goes_on_after_any_number_of_places_that_it_never_was_at(outliers: int) -> None:
    """The run behind them follows the one before them, however many runs of one position lie between."""
    flight = Flight().along(20)
    for outlier in range(outliers):
        flight.to(5_000.0 * (outlier + 1))
    assert flight.along(15, 25.0).found() == [NONE] * 20 + [JUMP] * outliers + [NONE] * 15


@pytest.mark.parametrize("places", [2, 8, 9])
def test_of_several_places_in_turns_one_stays_as_long_as_eight_runs_back(places: int) -> None:
    """Each run may follow one of the eight before it: of more places in turns only the first run is kept."""
    flight = Flight()
    for fix in range(10 * places):
        flight.to(5_000.0 * (fix % places))
    found = flight.found()
    assert found[0] == NONE
    assert found.count(NONE) == 10


def test_the_heaviest_of_several_chains_is_kept() -> None:
    """Three places in turns, of which the second is told twice as long each time."""
    flight = Flight()
    for fix in range(60):
        flight.to(5_000.0 * (fix % 3))
        if fix % 3 == 1:
            flight.to(5_000.0)
    found = np.array(flight.found())
    assert (found == NONE).sum() == 40
    assert (np.abs(flight.positions.lat_deg[found == NONE] - 47.445) < 0.001).all()


def test_each_boot_is_judged_for_itself() -> None:
    """A vehicle may be carried away before it is switched on again, and an outlier has one boot's to fear."""
    flight = Flight().along(5, start_m=9_000.0).reboot()
    flight.along(20).to(800.0).along(20, 25.0).reboot().to(0).to(700.0).to(0.0, after_s=30)
    expected = [NONE] * 25 + [JUMP] + [NONE] * 20 + [JUMP, NONE, NONE]
    assert flight.found() == expected


def test_positions_are_judged_in_the_order_of_time() -> None:
    """A late record is no jump where it belongs in time."""
    flight = Flight().along(40, speed_m_s=100.0, reported=False)
    late = np.array([*range(20), *range(21, 31), 20, *range(31, 40)])
    flight.rows = [flight.rows[row] for row in late]
    shuffled = flight.positions
    assert find_implausible(shuffled, np.argsort(late)).tolist() == [NONE] * 40
    assert JUMP in find_implausible(shuffled).tolist()
    shuffled.lacks_3d_fix[30] = True
    assert np.flatnonzero(find_implausible(shuffled, np.argsort(late)) == NO_FIX).tolist() == [30]


@pytest.mark.parametrize(
    ("lat_deg", "lon_deg", "reason"),
    [
        (0.0, 0.0, EMPTY),
        (0.0101, -0.0073, NEAR_ZERO),
        (-0.02, 0.02, NEAR_ZERO),
        (1e-7, 0.0, NEAR_ZERO),
        (90.0000001, 8.5, OUTSIDE),
        (-90.0000001, 8.5, OUTSIDE),
        (47.4, 180.0000001, OUTSIDE),
        (47.4, -180.0000001, OUTSIDE),
        (214.7483647, 214.7483647, OUTSIDE),
        (-214.7483648, -214.7483648, OUTSIDE),
    ],
)
def test_places_that_cannot_be_are_rejected(lat_deg: float, lon_deg: float, reason: Rejection) -> None:
    """No place, next to 0, 0, or not on the globe; what is around them stays."""
    assert Flight().along(5).at(lat_deg, lon_deg).along(5, 7).found() == [NONE] * 5 + [reason] + [NONE] * 5


@pytest.mark.parametrize(
    ("lat_deg", "lon_deg"),
    [(0.0, 8.5), (47.4, 0.0), (0.0200001, 0.0), (0.0, -0.0200001), (90.0, 180.0), (-90.0, -180.0)],
)
def test_unusual_places_are_plausible(lat_deg: float, lon_deg: float) -> None:
    """The equator, Greenwich, 2.3 km from 0, 0 and the poles are places like any other."""
    assert Flight().at(lat_deg, lon_deg).at(lat_deg, lon_deg).count() == 0


def test_the_first_rule_that_applies_gives_the_reason() -> None:
    """No position comes before no fix, and that before the place; jumps are looked for in what is left."""
    flight = Flight().at(0, 0, lacks_3d_fix=True).at(0.01, 0, lacks_3d_fix=True).at(95, 0, lacks_3d_fix=True)
    flight.to(0).at(40.0, 8.5, lacks_3d_fix=True).to(1.0)
    assert flight.found() == [EMPTY, NO_FIX, NO_FIX, NONE, NO_FIX, NONE]


@given(
    st.lists(st.tuples(st.integers(0, 3), st.integers(0, 2), st.integers(0, 1)), min_size=1, max_size=80),
)
def test_what_is_kept_never_jumps(steps: list[tuple[int, int, int]]) -> None:
    """Whatever the places and boots, each position kept can follow the one kept before it in its boot."""
    flight = Flight()
    for place, seconds, reboots in steps:
        flight.boot += reboots and seconds == 0
        flight.to(1_000.0 * place, after_s=seconds)
    positions = flight.positions
    kept = np.flatnonzero(find_implausible(positions) == NONE)
    north_m = FRAME.to_metres(positions.lat_deg, positions.lon_deg)[kept, 0]
    same = np.diff(positions.boot[kept]) == 0
    possible_m = 20.01 + 60 * np.diff(positions.time_s[kept])
    assert (np.abs(np.diff(north_m))[same] <= possible_m[same]).all()
    assert set(positions.boot[kept]) == set(positions.boot)


@pytest.mark.parametrize("kind", ["jumps at random", "reboots with jumps", "two places in turns"])
def test_time_grows_with_the_number_of_jumps_only(kind: str) -> None:
    """A hundred thousand jumps are judged in seconds; a machine at rest needs a third of one."""
    n = 100_000
    chance = np.random.default_rng(1)
    lat_deg = np.arange(n) % 2 / 10 + 47 if kind == "two places in turns" else chance.uniform(40, 50, n)
    boot = np.arange(n) // 4 if kind == "reboots with jumps" else np.zeros(n)
    positions = RecordedPositions(
        np.arange(n) / 4.0,
        lat_deg,
        np.full(n, 8.5),
        np.zeros(n).take,
        boot.astype(np.int32),
        np.zeros(n, np.bool_),
    )
    began_s = time.process_time()
    assert (find_implausible(positions) == JUMP).sum() >= n // 2
    assert time.process_time() - began_s < 5
