"""Streams of targets as ArduCopter 4.6 flew them: tests/data/arducopter/guided-targets.npz."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.guided_trajectory import Targets, simulate_targets
from flight_replay.simulator.flight.trajectory import Trajectory
from tests.helpers.paths import ARDUCOPTER

HOME_AMSL_M = 488.0


@dataclass(frozen=True, slots=True)
class GuidedRecording:
    """One stream, from a hover; seconds since its first target, metres north, east, up, radians."""

    name: str
    targets: Targets
    limits: Limits
    time_s: Floats
    position_m: Floats
    velocity_m_s: Floats
    yaw_rad: Floats

    def simulate(self) -> Trajectory:
        """The model's flight of the same targets."""
        first_m, first_m_s = self.position_m[0].tolist(), self.velocity_m_s[0].tolist()
        return simulate_targets(
            self.targets,
            self.limits,
            start_m=(first_m[0], first_m[1], first_m[2]),
            velocity_m_s=(first_m_s[0], first_m_s[1], first_m_s[2]),
            yaw_rad=float(self.yaw_rad[0]),
            home_amsl_m=HOME_AMSL_M,
            after_s=float(self.time_s[-1] - self.targets.time_s[-1]),
        )

    def errors_m(self, position_m: Floats) -> Floats:
        """How far positions at the recording's times are from the targets, while those are sent."""
        sent = self.targets.time_s
        during = self.time_s <= sent[-1]
        there = at_times(self.time_s[during], sent, self.targets.position_m)
        return distances_m(position_m[during], there)


def at_times(time_s: Floats, known_s: Floats, column: Floats | None) -> Floats:
    """A column of vectors between its times."""
    assert column is not None
    return np.column_stack([np.interp(time_s, known_s, part) for part in column.T])


def distances_m(here: Floats, there: Floats) -> Floats:
    """Row by row."""
    apart: Floats = np.sqrt(((here - there) ** 2).sum(axis=1))
    return apart


def guided_recordings() -> Iterator[GuidedRecording]:
    """The streams in the order of the flight."""
    with np.load(ARDUCOPTER / "guided-targets.npz") as data:
        columns = {name: data[name] for name in data.files}
    for stream, name in enumerate(columns["names"].tolist()):
        target = columns["target"][columns["target_stream"] == stream].astype(float)
        flown = columns["flown"][columns["flown_stream"] == stream].astype(float)
        # ArduCopter drops the acceleration of global targets that have position and velocity.
        accel = None if columns["is_global"][stream] else target[:, 7:10]
        yield GuidedRecording(
            name,
            Targets(target[:, 0], target[:, 1:4], target[:, 4:7], accel, target[:, 10], target[:, 11]),
            Limits(guided_timeout_s=float(columns["guid_timeout_s"][stream])),
            flown[:, 0],
            flown[:, 1:4],
            flown[:, 4:7],
            flown[:, 7],
        )
