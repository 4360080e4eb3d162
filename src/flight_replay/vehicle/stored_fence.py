"""The areas of the fence that a vehicle stores, as far as it can tell them.

It tells them by the mission protocol since 4.1, with a field that only MAVLink 2 has. Older firmware has
another protocol for its one polygon, which is not spoken here.
"""

from __future__ import annotations

from flight_replay.events import Listener, Notice
from flight_replay.exceptions import VehicleError
from flight_replay.mission.fence import FenceArea, FenceType, active_fence_types, areas_from_items
from flight_replay.vehicle.identity import Identity
from flight_replay.vehicle.link import timesync
from flight_replay.vehicle.link.link import Link
from flight_replay.vehicle.link.vehicle_link import VehicleLink
from flight_replay.vehicle.protocol.mission_download import FENCE, MissionDownloader

_OFFERS = 4
_NOT_TOLD = (
    "the route is not checked against the polygon of the vehicle's fence, which its firmware does not tell"
)
_PERHAPS_CIRCLES = (
    "the route is not checked against circles of the vehicle's fence that are placed on the map, if there "
    "are any: they can only be read over MAVLink 2 (SERIALn_PROTOCOL 2)"
)
_UNREADABLE = (
    "polygons and circles of the vehicle's fence can only be read over MAVLink 2, and this link is "
    "MAVLink 1; set SERIALn_PROTOCOL of the vehicle's port to 2, and whatever is between to MAVLink 2, "
    "then start again"
)


def stored_fence_areas(
    link: Link, vehicle_link: VehicleLink, identity: Identity, listener: Listener
) -> tuple[FenceArea, ...]:
    """The polygons and circles of a fence, if they are enabled; warns of those that cannot be read.

    Raises:
        VehicleError: The vehicle does not send them, they are invalid, or need MAVLink 2.
    """
    if FenceType.AREAS not in active_fence_types(identity.parameters):
        return ()
    points = identity.parameters.get("FENCE_TOTAL")
    if not identity.serves_fence:
        if points != 0 or not identity.version:
            listener(Notice(_NOT_TOLD, warning=True))
        return ()
    if _takes_mavlink2(link, vehicle_link):
        return areas_from_items(MissionDownloader(vehicle_link, as_int=True, mission_type=FENCE).run())
    if points != 0:
        raise VehicleError(_UNREADABLE)
    listener(Notice(_PERHAPS_CIRCLES, warning=True))  # FENCE_TOTAL counts them, too, but is 0 for one or two.
    return ()


def _takes_mavlink2(link: Link, vehicle_link: VehicleLink) -> bool:
    """Whether the vehicle sends MAVLink 2, if need be once it hears some: ports of 4.1 wait for that."""
    with vehicle_link.inbox("TIMESYNC") as inbox:
        for _ in range(_OFFERS):
            if link.vehicle_sends_mavlink2:
                break
            link.offer_mavlink2()
            stamp_ns = timesync.ping(vehicle_link)
            end_s = vehicle_link.now_s() + vehicle_link.round_trip.retry_s
            while (message := inbox.get(end_s - vehicle_link.now_s())) is not None:
                if message.ts1 == stamp_ns:
                    break
    return link.vehicle_sends_mavlink2
