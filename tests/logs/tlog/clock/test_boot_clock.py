"""The vehicle's clock over wraps, reboots and late records."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from flight_replay.logs.tlog.clock.boot_clock import BootClock, read_clock
from flight_replay.logs.tlog.columns import Positions

STAMP_US = 1_700_000_000_000_000


def clock_of(
    times_ms: list[int], stamps_s: list[float] | None = None, lat_deg: list[float] | None = None
) -> BootClock:
    """The clock of positions with those times, log stamps in seconds where there are any, and latitudes."""
    n = len(times_ms)
    whole = np.zeros(n, np.int32)
    stamps = np.zeros(n) if stamps_s is None else np.array(stamps_s)
    return read_clock(
        Positions(
            offset=np.arange(n) * 50,
            vehicle=np.full(n, 257, np.uint16),
            stamp_us=np.zeros(n, np.int64)
            if stamps_s is None
            else STAMP_US + (stamps * 1e6).astype(np.int64),
            time_ms=np.array(times_ms, np.uint32),
            lat_e7=whole if lat_deg is None else (np.array(lat_deg) * 1e7).astype(np.int32),
            lon_e7=whole,
            amsl_mm=whole,
            alt_mm=whole,
            north_cm_s=whole.astype(np.int16),
            east_cm_s=whole.astype(np.int16),
            down_cm_s=whole.astype(np.int16),
            heading_cdeg=whole.astype(np.uint16),
        )
    )


def in_order(clock: BootClock) -> NDArray[np.intp]:
    """All records in the order of time."""
    return clock.in_order(np.ones(len(clock.time_s), np.bool_))


def test_time_is_the_vehicles_own_clock() -> None:
    """Within one boot the time is time_boot_ms, gaps included, whatever the stamps say."""
    clock = clock_of([5_000, 5_250, 5_250, 9_000], [0, 100, 50, 7])
    assert clock.time_s.tolist() == [5.0, 5.25, 5.25, 9.0]
    assert clock.boot.tolist() == [0] * 4
    assert clock.order is None


def test_a_falling_clock_is_a_reboot_that_takes_no_time() -> None:
    """Without stamps that can be right, a reboot takes no time."""
    clock = clock_of([60_000, 60_500, 10_000, 10_500, 11_000])
    assert clock.boot.tolist() == [0, 0, 1, 1, 1]
    assert clock.time_s.tolist() == [60.0, 60.5, 60.5, 61.0, 61.5]


@pytest.mark.parametrize(
    ("gap_s", "bridged_s"), [(18.79, 18.79), (-523.0, 0.0), (90_000.0, 90_000.0), (-2e9, 0.0)]
)
def test_stamps_bridge_a_reboot_where_they_can_be_right(gap_s: float, bridged_s: float) -> None:
    """A gap between stamps that fall or cannot be right is left out; it may take days."""
    clock = clock_of([279_320, 18_925, 19_325], [0, gap_s, gap_s + 0.4])
    assert clock.boot.tolist() == [0, 1, 1]
    assert clock.time_s.tolist() == pytest.approx([279.32, 279.32 + bridged_s, 279.72 + bridged_s])


@pytest.mark.parametrize("passed_s", [86_400.0, -86_400.0])
def test_a_log_that_was_appended_is_another_boot_though_its_clock_is_higher(passed_s: float) -> None:
    """The stamps tell of another day, and the vehicle cannot have flown to where it is."""
    clock = clock_of([60_000, 60_500, 90_000, 90_500], [0, 0.5, passed_s, passed_s + 0.5], [47, 47, 48, 48])
    assert clock.boot.tolist() == [0, 0, 1, 1]
    later_s = max(passed_s - 0.5, 0.0)
    assert clock.time_s.tolist() == pytest.approx([60.0, 60.5, 60.5 + later_s, 61.0 + later_s])


def test_a_recorder_whose_clock_is_set_in_flight_cuts_no_flight() -> None:
    """The vehicle is where it can have flown to."""
    clock = clock_of([60_000, 60_500, 61_000], [0, 1e6, 1e6 + 0.5], [47, 47.0001, 47.0002])
    assert clock.boot.tolist() == [0, 0, 0]
    assert clock.time_s.tolist() == [60.0, 60.5, 61.0]


def test_stamps_move_a_clock_that_stands_still() -> None:
    """Of a sender without a clock the log's stamps are all there is, but for steps that cannot be right."""
    clock = clock_of([0] * 6, [10, 10.25, 10.25, 3, 3.5, 100_000])
    assert clock.time_s.tolist() == [0, 0.25, 0.25, 0.25, 0.75, 0.75]
    assert clock.boot.tolist() == [0] * 6
    assert clock_of([7_000, 7_000]).time_s.tolist() == [7.0, 7.0]


def test_a_wrapped_clock_is_no_reboot() -> None:
    """After 49.7 days the counter begins again, and time goes on."""
    clock = clock_of([2**32 - 500, 2**32 - 250, 0, 250])
    assert clock.boot.tolist() == [0] * 4
    assert np.allclose(np.diff(clock.time_s), 0.25)
    assert clock.time_s[0] == pytest.approx(4_294_966.796)


def test_a_record_from_before_a_wrap_may_come_after_it() -> None:
    """Late records are put in order across a wrap too."""
    clock = clock_of([2**32 - 500, 250, 2**32 - 250, 500])
    assert clock.boot.tolist() == [0] * 4
    assert in_order(clock).tolist() == [0, 2, 1, 3]
    assert np.allclose(np.diff(clock.time_s[in_order(clock)]), [0.25, 0.5, 0.25])


def test_a_clock_that_falls_from_high_to_far_behind_a_wrap_is_a_reboot() -> None:
    """A boot late in the counter's turn is told from a wrap by the time that would be missing."""
    assert clock_of([2**32 - 5_000_000, 10_000, 10_250]).boot.tolist() == [0, 1, 1]


def test_late_records_are_put_in_order_and_are_no_reboot() -> None:
    """Datagrams that overtake each other, singly or a second link's behind by seconds, share a boot."""
    single = clock_of([1_000, 1_250, 1_750, 1_500, 2_000])
    assert single.boot.tolist() == [0] * 5
    assert in_order(single).tolist() == [0, 1, 3, 2, 4]
    links = [[10_000 + 250 * step, 7_000 + 250 * step] for step in range(40)]
    both = clock_of([time for pair in links for time in pair])
    assert both.boot.tolist()[:70] == [0] * 70
    assert (np.diff(both.time_s[in_order(both)]) >= 0).all()


@pytest.mark.parametrize(("late", "boots"), [(1, 1), (16, 1), (17, 2)])
def test_as_many_as_16_records_in_a_row_may_come_late(late: int, boots: int) -> None:
    """Where more of them come, the vehicle booted: its clock was set right later."""
    before, after = [100_000, 100_250], [100_500, 100_750]
    clock = clock_of([*before, *range(50_000, 50_000 + 100 * late, 100), *after])
    assert clock.boot[-1] == boots - 1
    assert (clock.order is None) == (boots == 2)


def test_a_short_boot_that_runs_past_the_one_before_is_still_a_reboot() -> None:
    """A clock that climbs back step by step was reset."""
    first = list(range(5_000, 7_000, 250))
    second = list(range(4_000, 12_000, 250))
    assert clock_of(first + second).boot.tolist() == [0] * len(first) + [1] * len(second)


@given(st.lists(st.tuples(st.integers(0, 2**32 - 1), st.integers(-(2**50), 2**50)), min_size=1, max_size=60))
def test_time_never_falls_whatever_was_recorded(records: list[tuple[int, int]]) -> None:
    """In the order given, time and boot only go up, and every record is there once."""
    clock = clock_of([time for time, _ in records], [stamp / 1e6 for _, stamp in records])
    order = in_order(clock)
    assert sorted(order.tolist()) == list(range(len(records)))
    assert (np.diff(clock.time_s[order]) >= 0).all()
    assert set(np.diff(clock.boot[order]).tolist()) <= {0, 1}
