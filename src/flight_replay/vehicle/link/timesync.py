"""Measures the round trip by TIMESYNC, whose reply repeats the time at which the request was sent.

Neither a loss nor a repetition can make that ambiguous, unlike the answers to requests that were
sent again. Other stations keep time by it, too, and ArduPilot 4.6 sends its replies to everybody: the
stamp tells whose they are. ArduCopter 3.3 does not reply.
"""

from __future__ import annotations

from flight_replay.mavlink import Message, dialect
from flight_replay.vehicle.link.round_trip import NS_PER_S
from flight_replay.vehicle.link.vehicle_link import VehicleLink

MESSAGE_TYPE = "TIMESYNC"


def ping(link: VehicleLink) -> int:
    """Send a TIMESYNC request; its time stamp, ns, which the reply repeats."""
    now_ns = int(link.now_s() * NS_PER_S)
    link.round_trip.pinged(now_ns)
    link.send(dialect.MAVLink_timesync_message(0, now_ns))
    return now_ns


def measure(link: VehicleLink, message: Message) -> bool:
    """Whether a message is a TIMESYNC; a reply to us updates the round trip of the link."""
    if message.get_type() != MESSAGE_TYPE:
        return False
    if message.tc1 != 0:
        link.round_trip.answered(message.ts1, link.now_s())
    return True
