"""Plan many logs at once, on all cores or on a cluster, with Dask (pip install "dask[bag]").

    python examples/many_logs_dask.py LOG.tlog LOG.tlog ...

The logs are independent of each other, so that other schedulers work as well: Ray, or xargs -P.
"""

import sys
from pathlib import Path

from dask import bag

from flight_replay.errors import FlightReplayError
from flight_replay.logs.sample import sample_log
from flight_replay.logs.tlog import read_log
from flight_replay.planning.spacing import spaced_route


def plan(path: str) -> tuple[str, str]:
    """A log's name, and its plan or error: a log that cannot be read does not stop the others."""
    try:
        route = spaced_route(read_log(path).track)
    except FlightReplayError as error:
        return Path(path).name, str(error)
    return Path(path).name, f"{len(route.mission.waypoints)} waypoints, {route.path.length_m:.0f} m"


if __name__ == "__main__":
    logs = sys.argv[1:] or [str(sample_log())] * 4
    for name, result in (
        bag.from_sequence(logs, npartitions=len(logs)).map(plan).compute(scheduler="processes")
    ):
        print(f"{name}: {result}")
