"""How many waypoints does a flight need? Fit it with several maximum numbers and compare.

python examples/fit_budgets.py [LOG]
"""

import sys
from pathlib import Path

from flight_replay.logs.read_log import read_log
from flight_replay.logs.sample import default_log
from flight_replay.planning.fit import fit

log = read_log(Path(sys.argv[1]) if len(sys.argv) > 1 else default_log())
for max_points in (25, 50, 100):
    result = fit(log.track, max_points=max_points, speed_m_s="recorded")
    print(
        f"{len(result.mission.waypoints):4} waypoints: planned path error {result.planned_error.mean:.2f} m, "
        f"predicted path error {result.path_error.mean:.2f} m, "
        f"position error {result.position_error.mean:.1f} m, {result.predicted_duration_s:.0f} s"
    )
for note in result.notes:
    print(note)
