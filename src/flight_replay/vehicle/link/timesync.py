"""Measures the round trip by TIMESYNC, whose reply repeats the time at which the request was sent.

Neither a loss nor a repetition can make that ambiguous, unlike the answers to requests that were
sent again. ArduCopter 3.3 does not reply.
"""

from __future__ import annotations

from flight_replay.mavlink import Message, dialect
from flight_replay.vehicle.link.vehicle_link import VehicleLink

MESSAGE_TYPE = "TIMESYNC"
_NS_PER_S = 1e9


def ping(link: VehicleLink) -> int:
    """Send a TIMESYNC request; its time stamp, ns, which the reply repeats."""
    now_ns = int(link.now_s() * _NS_PER_S)
    link.send(dialect.MAVLink_timesync_message(0, now_ns))
    return now_ns


def measure(link: VehicleLink, message: Message) -> bool:
    """Whether a message is a TIMESYNC; a reply updates the round trip of the link."""
    if message.get_type() != MESSAGE_TYPE:
        return False
    if message.tc1 != 0:
        link.round_trip.measured(link.now_s() - message.ts1 / _NS_PER_S)
    return True
