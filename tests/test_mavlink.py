"""mavlink.py: what is received takes bounded memory, however it is cut into pieces."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable, Iterable

import pytest

from flight_replay.mavlink import dialect
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.protocol.channel import LinkChannel
from flight_replay.vehicle.link.admission import Admission
from flight_replay.vehicle.link.frame_parser import ParserPool
from tests.helpers.virtual_link import START

_GCS = dialect.MAVLink_heartbeat_message(dialect.MAV_TYPE_GCS, 8, 0, 0, 4, 3)
FRAME = bytes(_GCS.pack(dialect.MAVLink(None, 255, 190)))


def on_a_vehicles_link() -> Callable[[bytes], Iterable[object]]:
    pool = ParserPool()
    return lambda data: pool.messages(data, "sender")


def by_a_station() -> Callable[[bytes], Iterable[object]]:
    return Admission().frames


def by_the_copter() -> Callable[[bytes], Iterable[object]]:
    return LinkChannel(Autopilot(START), lambda _: None).receive


@pytest.mark.parametrize("made", [on_a_vehicles_link, by_a_station, by_the_copter])
def test_pieces_that_end_within_a_frame_do_not_fill_the_memory(
    made: Callable[[], Callable[[bytes], Iterable[object]]],
) -> None:
    """Three hundred kilobytes come, each frame of them, and none stays."""
    take = made()
    piece = FRAME[1:] + FRAME * 100 + FRAME[:1]
    list(take(FRAME + FRAME[:1]))
    tracemalloc.start()
    count = sum(len(list(take(piece))) for _ in range(150))
    kept = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert count == 150 * 101
    assert kept < 100_000
