"""Measures the round trip by TIMESYNC, whose reply repeats the time at which the request was sent.

Neither a loss nor a repetition can make that ambiguous, unlike the answers to requests that were
sent again. The link hears the replies. ArduCopter 3.3 does not reply.
"""

from __future__ import annotations

from flight_replay.mavlink import dialect
from flight_replay.vehicle.link.round_trip import NS_PER_S
from flight_replay.vehicle.link.vehicle_link import VehicleLink


def ping(link: VehicleLink) -> int:
    """Send a TIMESYNC request; its time stamp, ns, which the reply repeats."""
    now_ns = int(link.now_s() * NS_PER_S)
    link.round_trip.pinged(now_ns)
    link.send(dialect.MAVLink_timesync_message(0, now_ns))
    return now_ns
