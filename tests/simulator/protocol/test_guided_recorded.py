"""Recorded streams sent to the built-in copter as messages: it flies them as ArduCopter 4.6 did."""

from __future__ import annotations

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats
from flight_replay.mavlink import dialect
from flight_replay.simulator.autopilot.location import Start
from tests.helpers.guided_recording import GuidedRecording, at_times, distances_m, guided_recordings
from tests.helpers.sim_station import Station, sim

NO_POSITION, NO_VELOCITY, NO_ACCELERATION, NO_YAW, NO_RATE = 0b111, 0b111 << 3, 0b111 << 6, 1 << 10, 1 << 11
GLOBAL = "global-int"
HOME = Start(47.39, 8.54, 488.0, 0.0)
RECORDED = {recording.name: recording for recording in guided_recordings()}


def row(column: Floats | None, index: int, width: int) -> tuple[list[float], bool]:
    """A group of numbers as a message has them, and whether it is to be ignored."""
    if column is None:
        return [1.0] * width, False
    values = np.atleast_1d(column[index]).tolist()
    ignored = not np.isfinite(values).all()
    if ignored:
        values = [0.0] * width
    return ([values[0], values[1], -values[2]] if width == 3 else values), ignored


def message(recording: GuidedRecording, index: int) -> dialect.MAVLink_message:
    """The message that was sent; of global ones the acceleration, which is dropped, is made up."""
    targets = recording.targets
    groups = [
        row(targets.position_m, index, 3),
        row(targets.velocity_m_s, index, 3),
        row(targets.acceleration_m_s2, index, 3),
        row(targets.yaw_rad, index, 1),
        row(targets.yaw_rate_rad_s, index, 1),
    ]
    bits = (NO_POSITION, NO_VELOCITY, NO_ACCELERATION, NO_YAW, NO_RATE)
    mask = sum(bit for bit, (_, ignored) in zip(bits, groups, strict=True) if ignored)
    numbers = [value for values, _ in groups for value in values]
    if recording.name != GLOBAL:
        return dialect.MAVLink_set_position_target_local_ned_message(0, 1, 1, 1, mask, *numbers)
    there = HOME.location_of((numbers[0], numbers[1], -numbers[2]))
    return dialect.MAVLink_set_position_target_global_int_message(
        0, 1, 1, 6, mask, there.lat_e7, there.lon_e7, -numbers[2], *numbers[3:]
    )


def flown_m(recording: GuidedRecording, station: Station) -> Floats:
    """Positions of the copter, by the recording's times."""
    autopilot = station.autopilot
    targets = recording.targets
    begin_s, sent, rows = autopilot.time_s, 0, []
    while (now := autopilot.time_s - begin_s) <= recording.time_s[-1]:
        while sent < len(targets.time_s) and targets.time_s[sent] <= now + 1e-6:
            station.send(message(recording, sent))
            sent += 1
        rows.append((now, *autopilot.flight.position_m))
        station.run(0.02)
    columns = np.array(rows)
    return at_times(recording.time_s, columns[:, 0], columns[:, 1:])


@pytest.mark.parametrize(
    "name", ["eight", "snake-heading", "gap-half-s-timeout", "velocity-only", "velocity-acceleration", GLOBAL]
)
def test_messages_are_flown_as_arducopter_flew_them(name: str) -> None:
    """Positions within 0.15 m in the mean, errors to the targets within 0.1 m in mean, p95 and maximum."""
    recording = RECORDED[name]
    autopilot, station = sim(start=HOME, GUID_TIMEOUT=recording.limits.guided_timeout_s)
    station.fly(30.0)
    station.run(8.0)
    shift = np.array(autopilot.flight.position_m) - recording.position_m[0]
    flown = flown_m(recording, station)
    assert np.abs(shift).max() < 0.1
    assert distances_m(flown, recording.position_m).mean() <= 0.15
    if not np.isfinite(recording.targets.position_m).all():  # type: ignore[arg-type]
        return
    ours, theirs = recording.errors_m(flown), recording.errors_m(recording.position_m)
    slack = 0.2 if name == GLOBAL else 0.1
    for share in (0.5, 0.95, 1.0):
        assert np.quantile(ours, share) == pytest.approx(np.quantile(theirs, share), abs=slack)
