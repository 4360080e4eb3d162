"""Compare two flights: path error and position error of the second against the first.

    python examples/compare_flights.py [FIRST SECOND]

Without arguments, the sample flight is compared with a copy of it half a metre farther north.
"""

import sys
from dataclasses import replace
from pathlib import Path

import flight_replay
from flight_replay.exceptions import FlightReplayError

SAMPLE = Path(__file__).parents[1] / "data" / "flight.tlog"
METRES_PER_DEGREE = 111_319.5


def main() -> None:
    if len(sys.argv) not in (1, 3):
        sys.exit("usage: python examples/compare_flights.py [FIRST SECOND]")
    if len(sys.argv) > 1:
        first, second = (flight_replay.read_log(path).track for path in sys.argv[1:3])
    else:
        first = flight_replay.read_log(SAMPLE).track
        second = replace(first, lat_deg=first.lat_deg + 0.5 / METRES_PER_DEGREE)

    errors = flight_replay.errors(first, second)
    for name, error in (
        ("path error, first to second", errors.path_m.recorded_to_path.statistics),
        ("path error, second to first", errors.path_m.path_to_recorded.statistics),
        ("position error", errors.position_m.statistics),
    ):
        if error is not None:
            print(f"{name}: mean {error.mean:.2f} m, p95 {error.p95:.2f} m, max {error.max:.2f} m")


if __name__ == "__main__":
    try:
        main()
    except FlightReplayError as error:
        sys.exit(str(error))
