"""Logs of two links to one vehicle, of which one is late, and reboots that look alike."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flight_replay.logs.flights import find_flights
from flight_replay.logs.recording import Recording
from flight_replay.logs.tlog.arming.late_status import arrivals, without_late
from tests.helpers.log_writer import START_US, LogWriter
from tests.helpers.track_files import read_bytes
from tests.logs.tlog.clock.test_boot_clock import clock_of, in_order

FIRST_MS, STEP_MS, STEPS = 20_000, 250, 480
"""Two minutes of positions at 4 Hz, sent 20 s after the boot and later."""
ARMED_S, DISARMED_S = 30.3, 130.3
PROMPT_S = 0.02


def two_links(late_s: dict[str, float], is_copy: bool = True) -> Recording:
    """A log of a prompt link and a late one, by "lag", a "stall" that begins 80 s after the boot, "burst".

    Args:
        late_s: How late the second link is, seconds, by how.
        is_copy: Whether both bring the same positions, or each its own.
    """
    came: list[tuple[float, int, int]] = []
    for step in range(STEPS):
        for link in (0, 1):
            time_ms = FIRST_MS + STEP_MS * step + (0 if is_copy else 100 * link)
            sent_s = time_ms / 1e3
            came.append((_late(sent_s, late_s) if link else sent_s + PROMPT_S, time_ms, step))
    log = LogWriter()
    for came_s, time_ms, step in sorted(came, key=lambda each: each[0]):
        log.stamp_us = START_US + round(came_s * 1e6)
        if step % 4 == 0:
            log.heartbeat(ARMED_S <= time_ms / 1e3 < DISARMED_S)
        log.position(time_ms, 47.4 + 2e-8 * time_ms / STEP_MS, 8.5)
    return read_bytes(bytes(log.data))


def _late(sent_s: float, late_s: dict[str, float]) -> float:
    """When the late link brings what was sent."""
    if burst_s := late_s.get("burst"):
        return (math.floor(sent_s / burst_s) + 1) * burst_s + 0.08
    if 80 <= sent_s < 80 + late_s.get("stall", 0.0):
        return 80 + late_s["stall"] + 0.08
    return sent_s + late_s.get("lag", 0.08)


@pytest.mark.parametrize("is_copy", [True, False])
@pytest.mark.parametrize(
    "late_s",
    [
        {"lag": 3.0},
        {"lag": 0.3},
        {"burst": 0.5},
        {"burst": 1.0},
        {"burst": 8.0},
        {"stall": 2.0},
        {"stall": 15.0},
    ],
    ids=str,
)
def test_a_late_second_link_makes_neither_boots_nor_flights(late_s: dict[str, float], is_copy: bool) -> None:
    """All fixes are of one boot, once each, and the flight is what the prompt link says."""
    track = two_links(late_s, is_copy).track
    assert len(track) == STEPS * (1 if is_copy else 2)
    assert (np.diff(track.time_s) > 0).all()
    assert set(track.boot.tolist()) == {0}
    (flight,) = find_flights(track)
    assert track.time_s[flight.first] == pytest.approx(ARMED_S, abs=1.3)
    assert track.time_s[flight.last] == pytest.approx(DISARMED_S, abs=1.3)


@pytest.mark.parametrize("pace", [1, 10, 20])
@pytest.mark.parametrize("boot_s", [6.0, 30.0])
def test_a_simulator_that_boots_does_so_at_any_pace(pace: int, boot_s: float) -> None:
    """What it took in its own time is seen in the stamps, divided by the pace."""
    times_s = np.concatenate([np.arange(10, 200, 0.25), np.arange(boot_s, 150, 0.25)])
    stamps_s = np.append(0, np.cumsum(np.where(np.diff(times_s) < 0, boot_s, 0.25))) / pace
    clock = clock_of((times_s * 1e3).astype(int).tolist(), stamps_s.tolist())
    assert clock.order is None
    assert clock.boot[-1] == 1


def test_a_boot_has_a_pace_of_its_own() -> None:
    """The boots before it may have run at another."""
    times_s = np.concatenate([np.arange(10, 200, 0.25), np.arange(40, 60, 0.05)])
    stamps_s = np.append(0.25 * np.arange(760), 192.0 + 0.05 / 20 * np.arange(len(times_s) - 760))
    assert clock_of((times_s * 1e3).astype(int).tolist(), stamps_s.tolist()).boot[-1] == 1


@pytest.mark.parametrize(("lag_s", "boots"), [(590, 1), (610, 2)])
def test_no_link_is_ten_minutes_late(lag_s: int, boots: int) -> None:
    """What is so old is of another vehicle or clock."""
    times_s = [*range(1_000, 1_100), *range(1_100 - lag_s, 1_130 - lag_s)]
    clock = clock_of([1_000 * each for each in times_s], [0.5 * row for row in range(len(times_s))])
    assert len(set(clock.boot.tolist())) == boots


def test_a_backlog_may_end_the_log() -> None:
    """Then the clock does not come back to where it was."""
    times_ms = [*range(100_000, 160_000, 250), *range(140_000, 155_000, 250)]
    stamps_s = [*(0.25 * row for row in range(240)), *(60 + 0.001 * row for row in range(60))]
    clock = clock_of(times_ms, stamps_s)
    assert set(clock.boot.tolist()) == {0}
    assert (np.diff(clock.time_s[in_order(clock)]) >= 0).all()


@pytest.mark.parametrize("stamps_s", [[0.0] * 300, [-0.25 * row for row in range(300)], None])
def test_where_stamps_do_not_tell_many_late_records_are_a_boot(stamps_s: list[float] | None) -> None:
    """As without any: they stand still, or fall."""
    times_ms = [*range(100_000, 160_000, 250), *range(140_000, 155_000, 250)]
    assert clock_of(times_ms, stamps_s).boot[-1] == 1


def test_a_state_that_was_left_counts_anew_once_it_cannot_be_late() -> None:
    """Positions are 2.75 s late: what was left counts after 3.75 s, and only if it is still shown then."""
    offset = np.arange(0, 4_000, 10)
    time_s = np.arange(400) / 4
    time_s[1::2] -= 3.0
    came = arrivals(offset, time_s)
    assert came is not None
    at = np.array([0, 1_000, 1_041, 1_085, 2_000])
    state, since = without_late(np.array([0, 1, 0, 1, 0], np.uint8), at, came)
    assert (state.tolist(), since.tolist()) == ([0, 1, 1, 1, 0], at.tolist())
    state, since = without_late(np.array([0, 1, 0, 0, 0], np.uint8), at, came)
    assert (state.tolist(), since.tolist()) == ([0, 1, 1, 0, 0], [0, 1_000, 1_041, 1_139, 2_000])


def test_a_short_arming_stays_where_nothing_is_late() -> None:
    """Even one of a second."""
    assert arrivals(np.arange(3), np.array([1.0, 1.0, 2.0])) is None
    log = LogWriter()
    for step in range(40):
        log.stamp_us = START_US + 250_000 * step
        if step % 4 == 0:
            log.heartbeat(step in {12, 16, 24})
        log.position(20_000 + 250 * step)
    assert len(find_flights(read_bytes(bytes(log.data)).track)) == 2
