"""Measures the round trip by TIMESYNC, which comes back with the time at which it was sent.

No loss and no repetition can blur that, unlike the answers to requests that were sent again.
ArduCopter 3.3 does not answer it.
"""

from __future__ import annotations

from flight_replay.mavlink import Message, dialect
from flight_replay.vehicle.link.port import Port

KIND = "TIMESYNC"
_NS_PER_S = 1e9


def ping(port: Port) -> int:
    """Send a time to be echoed; the time, ns."""
    now_ns = int(port.now_s() * _NS_PER_S)
    port.send(dialect.MAVLink_timesync_message(0, now_ns))
    return now_ns


def learn(port: Port, message: Message) -> bool:
    """Whether a message is of this kind; from an echo the port's round trip is learnt."""
    if message.get_type() != KIND:
        return False
    if message.tc1 != 0:
        port.trip.took(port.now_s() - message.ts1 / _NS_PER_S)
    return True
