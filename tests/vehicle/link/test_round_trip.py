"""The timing of requests follows from the round trips measured."""

from __future__ import annotations

import numpy as np
import pytest

from flight_replay.mavlink import Message, dialect
from flight_replay.vehicle.link.round_trip import RoundTrip


def measured(*times_s: float) -> RoundTrip:
    round_trip = RoundTrip()
    for seconds in times_s:
        round_trip.measured(seconds)
    return round_trip


def test_a_slow_link_is_assumed_before_the_first_measurement() -> None:
    """A retry after about a second, and two messages in flight."""
    assert RoundTrip().median_s == 0.7
    assert RoundTrip().retry_s == pytest.approx(1.05)
    assert RoundTrip().window == 2


def test_one_late_answer_does_not_change_the_timing() -> None:
    """The median of the last nine counts: an answer that was repeated after a second is an outlier."""
    assert measured(0.1, 0.1, 1.1).median_s == 0.1
    assert measured(*[1.0] * 9, *[0.1] * 5).median_s == 0.1


def test_an_estimate_counts_only_before_the_first_measurement() -> None:
    """It is better than nothing, and worse than a measurement."""
    round_trip = RoundTrip()
    round_trip.estimated(0.3)
    assert round_trip.median_s == 0.3
    round_trip.estimated(5.0)
    assert round_trip.median_s == 0.3


def reply(stamp_ns: float, vehicle_ns: int = 7) -> Message:
    return dialect.MAVLink_timesync_message(vehicle_ns, int(stamp_ns))


def test_an_answer_counts_once_and_only_to_an_own_ping() -> None:
    """Another station's stamps are of another clock: nanoseconds since 1970, from mavros."""
    round_trip = RoundTrip()
    round_trip.pinged(5_000_000_000)
    round_trip.answered(reply(1_795_879_994e9), 5.1)
    round_trip.answered(reply(5e9, vehicle_ns=0), 5.1)
    assert round_trip.median_s == 0.7, "neither another station's nor a question"
    round_trip.answered(reply(5e9), 5.2)
    round_trip.answered(reply(5e9), 9.0)
    round_trip.answered(reply(5e9), 9.1)
    assert round_trip.median_s == pytest.approx(0.2)


def test_a_round_trip_that_takes_longer_than_the_next_ping_is_measured() -> None:
    """A link that becomes slow in flight: every reply counts, once, though others were sent meanwhile."""
    round_trip = measured(0.1)
    for now_s in np.arange(1.0, 11.0, 0.5):
        round_trip.pinged(int(now_s * 1e9))
        for _ in range(2):
            round_trip.answered(reply((now_s - 1.5) * 1e9), now_s)
    assert round_trip.median_s == pytest.approx(1.5)
    assert round_trip.from_freshest_s == pytest.approx(1.5)


def test_old_pings_are_forgotten() -> None:
    """A vehicle that never answers costs no memory."""
    round_trip = RoundTrip()
    for stamp_ns in range(1000):
        round_trip.pinged(stamp_ns)
    round_trip.answered(reply(1), 5.0)
    assert round_trip.median_s == 0.7


@pytest.mark.parametrize(("round_trip_s", "retry_s"), [(0.2, 0.3), (0.01, 0.04), (10.0, 3.0)])
def test_a_request_is_repeated_after_one_and_a_half_round_trips(round_trip_s: float, retry_s: float) -> None:
    """No sooner than 0.04 s, no later than 3 s."""
    assert measured(round_trip_s).retry_s == pytest.approx(retry_s)


def test_losses_in_a_row_back_off_until_an_answer_comes() -> None:
    """The wait doubles after each four losses, up to 3 s; a measurement ends it."""
    round_trip = measured(0.2)
    waits_s = []
    for _ in range(20):
        waits_s.append(round_trip.retry_s)
        round_trip.lost()
    assert waits_s == pytest.approx([0.3] * 4 + [0.6] * 4 + [1.2] * 4 + [2.4] * 4 + [3.0] * 4)
    round_trip.measured(0.2)
    assert round_trip.retry_s == pytest.approx(0.3)


@pytest.mark.parametrize(("round_trip_s", "window"), [(0.01, 2), (0.4, 10), (5.0, 24)])
def test_more_messages_are_in_flight_on_a_slow_link(round_trip_s: float, window: int) -> None:
    """One for each 40 ms of the round trip, from 2 to 24."""
    assert measured(round_trip_s).window == window
