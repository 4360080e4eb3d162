"""Replay a log on the built-in copter, twenty times faster than real time, and measure the path error.

python examples/replay_builtin.py [LOG.tlog]
"""

import sys

from flight_replay import vehicle
from flight_replay.events import Event, WaypointReached
from flight_replay.logs.read_log import read_log
from flight_replay.logs.sample import sample_log
from flight_replay.output.outcome import compare_flight
from flight_replay.planning.altitude import home_of
from flight_replay.planning.spacing import spaced_route
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.server import launch
from flight_replay.supervisor import Plan, WallClock, fly

SPEEDUP = 20.0


def listener(event: Event) -> None:
    """The supervisor emits an event for everything that happens; this prints one kind of them."""
    if isinstance(event, WaypointReached):
        print(f"waypoint {event.seq} at {event.time_s:.1f} s")


track = read_log(sys.argv[1] if len(sys.argv) > 1 else sample_log()).track
route = spaced_route(track, max_points=30)
home = home_of(track)
start = Start(home.lat_deg, home.lon_deg, home.alt_amsl_m)
with (
    launch.run(start, speedup=SPEEDUP) as copter,
    vehicle.connect(copter.connection, speedup=SPEEDUP) as connected,
):
    connected.upload(route.mission)
    record = fly(connected, WallClock(), Plan(mission=route.mission, duration_s=30.0), listener)

outcome = compare_flight(route, record)
print(f"{record.waypoints_reached} waypoints in {record.auto_s:.0f} s of AUTO, ended by: {record.ended}")
for way, errors in (
    ("recorded to flown", outcome.errors.path_m.recorded_to_path),
    ("flown to recorded", outcome.errors.path_m.path_to_recorded),
):
    if len(errors):
        print(f"path error, {way}: mean {errors.error.mean():.2f} m, max {errors.error.max():.2f} m")
