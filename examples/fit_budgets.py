"""How many waypoints does a flight need? Fit it within several budgets and compare.

python examples/fit_budgets.py [LOG]
"""

import sys
from pathlib import Path

from flight_replay.logs.sample import default_log
from flight_replay.logs.tlog import read_log
from flight_replay.planning.fit import fit

log = read_log(Path(sys.argv[1]) if len(sys.argv) > 1 else default_log())
for budget in (25, 50, 100):
    found = fit(log.track, max_points=budget, speed_m_s="recorded")
    print(
        f"{len(found.mission.waypoints):4} waypoints: planned {found.planned_error.mean:.2f} m off, "
        f"flown {found.path_error.mean:.2f} m in space and {found.position_error.mean:.1f} m in time, "
        f"in {found.predicted_duration_s:.0f} s"
    )
for note in found.notes:
    print(note)
