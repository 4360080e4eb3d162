"""Plan a mission from a log and save it; nothing flies.

python examples/plan_only.py [LOG.tlog [MISSION.waypoints]]
"""

import sys

from flight_replay.exceptions import FlightReplayError
from flight_replay.logs.flights import find_flights
from flight_replay.logs.read_log import read_log
from flight_replay.logs.sample import sample_log
from flight_replay.mission import formats
from flight_replay.planning.spacing import spaced_route


def main() -> None:
    log = read_log(sys.argv[1] if len(sys.argv) > 1 else sample_log())
    for flight in find_flights(log.track):
        print(f"flight {flight.number}: {flight.fixes} fixes, {flight.length_m:.0f} m")

    route = spaced_route(log.track, altitude_m=20.0)
    print(f"{len(route.mission.waypoints)} waypoints, {route.path.length_m:.0f} m")
    for way, errors in (
        ("recorded to planned", route.planned_error.recorded_to_path),
        ("planned to recorded", route.planned_error.path_to_recorded),
    ):
        print(f"path error, {way}: mean {errors.error.mean():.2f} m, max {errors.error.max():.2f} m")

    formats.save(sys.argv[2] if len(sys.argv) > 2 else "mission.waypoints", route.mission, route.covered)


if __name__ == "__main__":
    try:
        main()
    except FlightReplayError as error:
        sys.exit(str(error))
