"""What is read of a log, whatever its format: one vehicle's track, and what was left out of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from flight_replay.logs.track import Track
from flight_replay.logs.vehicles import VehicleCount


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Recording:
    """What a log holds of one vehicle.

    Attributes:
        path: The log's name.
        bytes: The log's bytes, unpacked.
        vehicles: All that recorded positions, the one to be replayed by default first; empty where the
            format has no MAVLink ids.
        vehicle: The one of them that was read.
        track: Its usable fixes, one at least.
        format: Its format's name in the table of ``log_formats``, with whose reader it was read.
        without_position: How many of its records were at latitude and longitude 0.
        rejected: How many of its positions were implausible, by reason.
        modes: ArduPilot's flight mode at each fix of the track (n,), as in ``flight_modes``, -1 where it
            is unknown; None where the log does not tell.
        firmware: What the log says of it, such as "ArduCopter V4.6.0".
        vehicle_type: The kind of vehicle in words, such as "quadcopter" or "fixed wing".
        is_multicopter: Whether that kind of vehicle is a multicopter; None where the log does not tell.
        start_utc_s: When the first fix of the track was recorded, Unix time.
        notes: What a person should know about how the log was read, one sentence each.
    """

    path: str
    bytes: int
    track: Track
    format: str = ""
    vehicles: tuple[VehicleCount, ...] = ()
    vehicle: VehicleCount | None = None
    without_position: int = 0
    rejected: Mapping[str, int] = field(default_factory=dict)
    modes: NDArray[np.int16] | None = None
    firmware: str | None = None
    vehicle_type: str | None = None
    is_multicopter: bool | None = None
    start_utc_s: float | None = None
    notes: tuple[str, ...] = ()

    def utc_s_of(self, part: Track) -> float | None:
        """The Unix time of the first fix of a part of the track that still has its clock."""
        if self.start_utc_s is None:
            return None
        return self.start_utc_s + float(part.time_s[0] - self.track.time_s[0])

    @property
    def rejected_total(self) -> int:
        """How many positions were implausible."""
        return sum(self.rejected.values())
