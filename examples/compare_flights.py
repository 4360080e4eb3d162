"""How far apart are two flights? In space, the second against the path of the first; and in time.

    python examples/compare_flights.py [FIRST.tlog SECOND.tlog]

Without arguments, the sample flight is compared with itself, flown half a metre farther north.
"""

import sys
from dataclasses import replace

import numpy as np

from flight_replay.geometry.distances import error_statistics, path_errors_m, position_errors_m
from flight_replay.logs.sample import sample_log
from flight_replay.logs.tlog import read_log

if len(sys.argv) > 2:
    first, second = read_log(sys.argv[1]).track, read_log(sys.argv[2]).track
else:
    first = read_log(sample_log()).track
    lat_deg, lon_deg = first.frame.to_degrees(first.north_east_m() + np.array([0.5, 0.0]))
    second = replace(first, lat_deg=lat_deg, lon_deg=lon_deg)

frame = first.frame
first_m, second_m = first.north_east_m(frame), second.north_east_m(frame)
space = error_statistics(path_errors_m(second_m, first_m))
late = error_statistics(
    position_errors_m(second.time_s - second.time_s[0], second_m, first.time_s - first.time_s[0], first_m)
)
for name, distances in (("in space", space), ("in time", late)):
    if distances is not None:
        print(f"{name}: mean {distances.mean:.2f} m, p95 {distances.p95:.2f} m, max {distances.max:.2f} m")
