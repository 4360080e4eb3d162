"""A vehicle that has fallen and stays there armed: in RTL its motors go on running, in LAND it disarms."""

from __future__ import annotations

from flight_replay.events import Notice, VehicleState
from flight_replay.geometry.geodesy import ground_distance_m
from flight_replay.supervisor.timers import RETRY_S, Deadline, RetryTimer
from flight_replay.supervisor.vehicle_monitor import VehicleMonitor

_STILL_M, _STILL_S = 3.0, 6.0
"""RTL moves a vehicle that flies farther in that time, and one that lies on the ground hops: nobody has come
near it so soon."""
_WATCH_S = 15.0  # RTL may be confirmed while it still falls.
_DISARM_S = 20.0  # ArduCopter 4.6, at full throttle by then, disarms 8 to 13 s after the request.
_LAND_M_S = 0.5  # ArduCopter's by default, near the ground: it may hover there weakly, rather than lie.
_STAYS = "the vehicle stays where it fell"


def moved_m(a: VehicleState, b: VehicleState) -> float:
    """How far it is from one place to another, over the ground and up, metres."""
    return ground_distance_m(a, b) + abs(a.alt_m - b.alt_m)


def disarm_if_staying(monitor: VehicleMonitor) -> str | None:
    """Command LAND of a vehicle that fell and that RTL does not move: what came of it, as a sentence.

    None if it flies home, or is disarmed.

    Raises:
        FlightEnded: Somebody else chose another mode, the link stays lost, or the vehicle rebooted.
    """
    if not _comes_to_stay(monitor):
        return None
    monitor.emit(Notice(f"{_STAYS}; LAND is commanded, so that it disarms", warning=True))
    monitor.told_to_land = True
    monitor.begin_phase()
    monitor.modes.expect_change("LAND")
    landing_s = max(monitor.altitude_m, 0.0) / _LAND_M_S
    deadline, retry = Deadline(monitor, landing_s + _DISARM_S), RetryTimer(monitor)
    while not monitor.certainly_disarmed:
        if deadline.passed:
            return f"{_STAYS}, and has not disarmed in LAND: keep away, and disarm it on the ground"
        if not monitor.modes.changed and not monitor.mode_in_doubt and retry.due(RETRY_S):
            monitor.vehicle.request_mode("LAND")
        monitor.step()
    return f"{_STAYS}, and has disarmed in LAND"


def _comes_to_stay(monitor: VehicleMonitor) -> bool:
    """Whether it comes to stay somewhere, armed."""
    deadline = Deadline(monitor, _WATCH_S)
    since_s, there = monitor.link_up_s, monitor.state
    while not (deadline.passed or monitor.certainly_disarmed):
        now = monitor.state
        over_home = monitor.from_home_m < _STILL_M < monitor.altitude_m  # RTL waits there.
        if now is None or there is None or over_home or moved_m(there, now) > _STILL_M:
            since_s, there = monitor.link_up_s, now
        if monitor.link_up_s - since_s > _STILL_S:
            return True
        monitor.step()
    return False
