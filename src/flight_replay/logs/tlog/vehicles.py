"""Which vehicles a log tells of, and whether one was armed: by its autopilot's heartbeats only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Indices
from flight_replay.logs.tlog.columns import Heartbeats
from flight_replay.logs.track import Armed


@dataclass(frozen=True, slots=True)
class VehicleId:
    """A MAVLink system id, and a component id where one is asked for."""

    system: int
    component: int | None = None

    def __str__(self) -> str:
        return str(self.system) if self.component is None else f"{self.system}:{self.component}"


@dataclass(frozen=True, slots=True)
class VehicleCount:
    """A vehicle that sent positions, and how many of them are usable."""

    system: int
    component: int
    fixes: int

    @property
    def id(self) -> VehicleId:
        """The vehicle's name."""
        return VehicleId(self.system, self.component)

    def is_named(self, wanted: VehicleId) -> bool:
        """Whether ``wanted`` means this vehicle."""
        return self.system == wanted.system and wanted.component in (None, self.component)


_NO_AUTOPILOT = 8  # MAV_AUTOPILOT_INVALID: ground stations, radios, gimbals and other components
_AUTOPILOTS = 3, 12  # MAV_AUTOPILOT_ARDUPILOTMEGA, MAV_AUTOPILOT_PX4
# MAV_TYPE of what may share a vehicle's ids without being one: ground station, onboard controller,
# gimbal, ADS-B, camera to Open Drone ID, battery to winch, illuminator, gripper, radio.
_NO_VEHICLE_TYPES = np.array([6, 18, 26, 27, *range(30, 35), *range(36, 43), 44, 48, 49])


def _of_autopilot(heartbeats: Heartbeats) -> Heartbeats:
    """The heartbeats that an autopilot sent: of the first kind in ``_AUTOPILOTS`` that there is, else all.

    Scripts that send heartbeats under the vehicle's ids name no autopilot, or the generic one.
    """
    is_vehicle = ~np.isin(heartbeats.type, _NO_VEHICLE_TYPES)
    kept = heartbeats.select((heartbeats.autopilot != _NO_AUTOPILOT) & is_vehicle)
    for autopilot in _AUTOPILOTS:
        own = kept.autopilot == autopilot
        if own.any():
            return kept.select(own)
    return kept


def armed_at(offset: NDArray[np.int64], boot: NDArray[np.int32], heartbeats: Heartbeats) -> NDArray[np.int8]:
    """Whether the motors were armed at any time since the fix before, shape (n,), by the heartbeats.

    So a flight lasts from the first fix after they were reported armed to the first after disarmed.
    Fixes are in the order of time; one that came late into the log is placed with those that follow it.
    """
    heartbeats = _of_autopilot(heartbeats)
    reported = np.append(np.int8(Armed.UNKNOWN), heartbeats.armed.astype(np.int8))
    timely = np.minimum.accumulate(offset[::-1])[::-1]
    firsts = np.searchsorted(timely, heartbeats.offset)  # far fewer than fixes, so this way round
    armed = np.repeat(reported, np.diff(firsts, prepend=0, append=len(offset)))
    _forget_boots_before(armed, boot, reported, firsts)
    armed[1:] = np.where(boot[1:] == boot[:-1], np.maximum(armed[1:], armed[:-1]), armed[1:])
    return np.asarray(armed)


def _forget_boots_before(
    armed: NDArray[np.int8], boot: NDArray[np.int32], reported: NDArray[np.int8], firsts: Indices
) -> None:
    """Take back the word "armed" of the boot before from the fixes (n,) ahead of a boot's own first word.

    A vehicle that boots is disarmed. Of equal words in a row only the first and last are known, so
    where the next one is "armed" too, nobody can tell that there was none in between.

    Args:
        armed: What is reported at each fix (n,), changed in place.
        boot: The boot of each fix (n,).
        reported: "unknown" and the words (m + 1,).
        firsts: The first fix after each word (m,).
    """
    starts = np.flatnonzero(np.diff(boot)) + 1
    last = np.searchsorted(firsts, starts, "right")
    following = np.append(reported[1:], np.int8(Armed.UNKNOWN))[last]
    ends = np.append(firsts, len(armed))[last]
    old = (reported[last] == Armed.YES) & (following != Armed.YES)
    changes = np.zeros(len(armed) + 1, np.int64)
    np.add.at(changes, starts[old], 1)
    np.add.at(changes, ends[old], -1)
    armed[np.cumsum(changes[:-1]) > 0] = Armed.UNKNOWN
