"""How many waypoints does a flight need? Fit it with several maximum numbers and compare.

python examples/fit_budgets.py [LOG]
"""

import sys

import flight_replay
from flight_replay.exceptions import FlightReplayError
from flight_replay.logs.sample import default_log


def main() -> None:
    log = flight_replay.read_log(sys.argv[1] if len(sys.argv) > 1 else default_log())
    for max_points in (25, 50, 100):
        route = flight_replay.fit(log.track, max_points=max_points, speed_m_s="recorded")
        planned, predicted = route.planned_error, route.predicted
        assert predicted is not None, "only missions that the model cannot fly have none"
        print(
            f"{len(route.mission.waypoints):4} waypoints: "
            f"planned path error {planned.recorded_to_path.error.mean():.2f} m, "
            f"predicted path error {predicted.path_m.recorded_to_path.error.mean():.2f} m, "
            f"position error {predicted.position_m.error.mean():.1f} m, {route.predicted_duration_s:.0f} s"
        )
    for note in route.notes:
        print(note)


if __name__ == "__main__":
    try:
        main()
    except FlightReplayError as error:
        sys.exit(str(error))
