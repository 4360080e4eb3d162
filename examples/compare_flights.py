"""Compare two flights: path error and position error of the second against the first.

    python examples/compare_flights.py [FIRST.tlog SECOND.tlog]

Without arguments, the sample flight is compared with a copy of it half a metre farther north.
"""

import sys
from dataclasses import replace

import numpy as np

from flight_replay.geometry.distances import error_statistics, path_errors_m, position_errors_m
from flight_replay.logs.read_log import read_log
from flight_replay.logs.sample import sample_log

if len(sys.argv) > 2:
    first, second = read_log(sys.argv[1]).track, read_log(sys.argv[2]).track
else:
    first = read_log(sample_log()).track
    lat_deg, lon_deg = first.frame.to_degrees(first.north_east_m() + np.array([0.5, 0.0]))
    second = replace(first, lat_deg=lat_deg, lon_deg=lon_deg)

first_m, second_m = first.north_east_m(first.frame), second.north_east_m(first.frame)
first_s, second_s = first.time_s - first.time_s[0], second.time_s - second.time_s[0]
errors = {
    "path error": path_errors_m(second_m, first_m),
    "position error": position_errors_m(second_s, second_m, first_s, first_m),
}
for name, errors_m in errors.items():
    error = error_statistics(errors_m)
    if error is not None:
        print(f"{name}: mean {error.mean:.2f} m, p95 {error.p95:.2f} m, max {error.max:.2f} m")
