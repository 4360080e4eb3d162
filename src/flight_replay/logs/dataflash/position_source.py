"""Which records of a DataFlash log are taken for the vehicle's positions, and how it moved there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats
from flight_replay.logs.dataflash.log_sections import LogSections
from flight_replay.logs.dataflash.message_tables import GpsPositions, LoggedPositions, LoggedVelocities
from flight_replay.logs.dataflash.nearest_records import values_near

_LEAST_COVERED = 0.8  # a log that lost more of POS than of GPS has a better track in the latter


@dataclass(frozen=True, slots=True, eq=False)
class PositionSource:
    """The positions that count, with velocities north, east and up (n, 3) where known.

    ``note`` says why they are not the usual ones.
    """

    positions: LoggedPositions
    velocity_m_s: Floats
    lacks_3d_fix: Flags
    note: str | None = None

    @property
    def counts(self) -> Flags:
        """Which of them (n,) have a place that the receiver knew."""
        return _has_place(self.positions) & ~self.lacks_3d_fix


def choose_positions(
    pos: LoggedPositions, gps: GpsPositions, velocities: LoggedVelocities, sections: LogSections
) -> PositionSource:
    """POS, or one receiver's GPS where POS is missing for more than a fifth of the time.

    Args:
        pos: The positions that the vehicle held for its own.
        gps: Those of its receivers.
        velocities: Those of the estimator in use.
        sections: The sections of the log.
    """
    receiver = gps.select(_of_one_receiver(gps))
    pos_s = _covered_s(pos, sections, _has_place(pos))
    gps_s = _covered_s(receiver, sections, _has_place(receiver) & receiver.has_3d_fix)
    if len(pos) and (not len(receiver) or pos_s >= _LEAST_COVERED * gps_s):
        return PositionSource(pos, _velocities_m_s(pos, velocities), np.zeros(len(pos), np.bool_))
    why = f"POS has only {pos_s} of its {gps_s} s" if len(pos) else "POS is missing"
    note = f"Positions are those of the GPS receiver: {why}"
    return PositionSource(receiver, _receiver_velocities_m_s(receiver), ~receiver.has_3d_fix, note)


def _of_one_receiver(gps: GpsPositions) -> Flags:
    """Which records (n,) are of the receiver that the autopilot used most often; else of the first."""
    counts = np.bincount(gps.instance[gps.is_used & gps.has_3d_fix], minlength=1)
    if not counts.any():
        counts = -np.bincount(gps.instance[gps.has_3d_fix], minlength=1)
        known = np.flatnonzero(counts)
        return np.asarray(gps.instance == (known[0] if len(known) else gps.instance.min(initial=0)))
    return np.asarray(gps.instance == counts.argmax())


def _has_place(positions: LoggedPositions) -> Flags:
    return np.asarray((positions.lat_deg != 0) | (positions.lon_deg != 0))


def _covered_s(positions: LoggedPositions, sections: LogSections, counts: Flags) -> int:
    """In how many seconds there is a position that counts (n,)."""
    if not counts.any():
        return 0
    second = np.floor(positions.time_s[counts]).astype(np.int64)
    section = sections.of(positions.offset[counts])
    return 1 + int(np.count_nonzero((np.diff(second) != 0) | (np.diff(section) != 0)))


def _velocities_m_s(positions: LoggedPositions, velocities: LoggedVelocities) -> Floats:
    """The estimator's velocities at positions (n, 3), not numbers where there are none."""
    columns = velocities.north_m_s, velocities.east_m_s, -velocities.down_m_s
    return values_near(positions, velocities, columns)


def _receiver_velocities_m_s(gps: GpsPositions) -> Floats:
    """The receiver's velocities (n, 3)."""
    course_rad = np.radians(gps.course_deg.astype(float))
    speed_m_s = gps.ground_speed_m_s.astype(float)
    return np.column_stack(
        [speed_m_s * np.cos(course_rad), speed_m_s * np.sin(course_rad), -gps.down_m_s.astype(float)]
    )
