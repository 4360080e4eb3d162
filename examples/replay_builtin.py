"""Replay half a minute of a log on a simulator, twenty times faster than real time, and measure the error.

python examples/replay_builtin.py [LOG]
"""

import sys
from pathlib import Path

import flight_replay
from flight_replay.events import Event, WaypointReached
from flight_replay.exceptions import FlightReplayError

SAMPLE = Path(__file__).parents[1] / "data" / "flight.tlog"


def listener(event: Event) -> None:
    """The supervisor emits an event for everything that happens; this prints one kind of them."""
    if isinstance(event, WaypointReached):
        print(f"waypoint {event.seq} at {event.time_s:.1f} s")


def main() -> None:
    track = flight_replay.read_log(sys.argv[1] if len(sys.argv) > 1 else SAMPLE).track
    route = flight_replay.plan(track, max_points=30)
    replay = flight_replay.replay(route, duration_s=30.0, speedup=20.0, listener=listener)

    record, errors = replay.record, replay.outcome.errors.path_m
    print(f"{record.waypoints_reached} waypoints in {record.auto_s:.0f} s of AUTO, ended by: {record.ended}")
    for way, error in (
        ("recorded to flown", errors.recorded_to_path.statistics),
        ("flown to recorded", errors.path_to_recorded.statistics),
    ):
        if error is not None:
            print(f"path error, {way}: mean {error.mean:.2f} m, max {error.max:.2f} m")


if __name__ == "__main__":
    try:
        main()
    except FlightReplayError as error:
        sys.exit(str(error))
