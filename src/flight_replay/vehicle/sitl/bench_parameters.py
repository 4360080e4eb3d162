"""Parameters that a bare ArduCopter SITL binary lacks: it boots uncalibrated, so that it cannot be armed.

The values match the simulated sensors: SIM_MAG1_OFS is (5, 13, -18), the accelerometers have no
error (any offset other than zero counts as calibrated), and the simulated RC input is 1000 to 2000. The
yaw gains are those that ArduPilot's own scripts give the simulated frame: with the compiled ones it turns
0.1 to 0.2 s later, and the model of ArduCopter is one with these.
"""

from __future__ import annotations

from collections.abc import Iterator

_COMPASSES = ("", "2", "3")
_COMPASS_OFFSETS = {"X": 5, "Y": 13, "Z": -18}
_IMUS = ("", "2")  # A third sensor, which does not exist, would count as uncalibrated.
_CHANNELS = range(1, 9)
_CHANNEL_RANGE = {"MIN": 1000, "MAX": 2000, "TRIM": 1500}


def bench_parameters() -> Iterator[tuple[str, float]]:
    """Names and values, for ArduCopter 3.3 and later; a firmware ignores the names it does not know."""
    yield "FRAME_CLASS", 1
    yield "FRAME_TYPE", 0
    yield "FRAME", 0
    yield "BATT_MONITOR", 4
    yield "ATC_RAT_YAW_P", 0.3
    yield "ATC_RAT_YAW_I", 0.02
    yield "MOT_THST_HOVER", 0.39
    yield "MOT_BAT_VOLT_MIN", 9.6
    yield "MOT_BAT_VOLT_MAX", 12.8
    yield "COMPASS_LEARN", 0
    for compass in _COMPASSES:
        for axis, offset in _COMPASS_OFFSETS.items():
            yield f"COMPASS_OFS{compass}_{axis}", offset
    for imu in _IMUS:
        for axis in "XYZ":
            yield f"INS_ACC{imu}OFFS_{axis}", 0.001
            yield f"INS_ACC{imu}SCAL_{axis}", 1.001
    for channel in _CHANNELS:
        for end, width in _CHANNEL_RANGE.items():
            yield f"RC{channel}_{end}", width


def bench_text() -> str:
    """The same as the content of a parameter file for ``--defaults``."""
    return "".join(f"{name} {value:g}\n" for name, value in bench_parameters())
