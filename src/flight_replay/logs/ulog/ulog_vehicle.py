"""What a ULog says of the vehicle that recorded it."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.logs.ulog.ulog_file import UlogTopics
from flight_replay.logs.vehicle_kinds import VehicleKind, kind_of

_TYPES = {1: VehicleKind("rotary wing"), 2: VehicleKind("fixed wing", False), 3: VehicleKind("rover", False)}
"""VEHICLE_TYPE of PX4's VehicleStatus."""
_STAGES = ((255, ""), (192, " release candidate"), (128, " beta"), (64, " alpha"), (0, " dev"))
"""The last byte of a version: from which number on it is what."""


def kind_of_ulog(read: UlogTopics) -> VehicleKind:
    """The vehicle's kind and firmware, None where the log does not tell."""
    firmware = _firmware(read)
    status = read.topics.get("vehicle_status")
    if status is None:
        return VehicleKind(firmware=firmware)
    kind = kind_of(_most_frequent(status.get("system_type")), firmware)
    if kind.name is None:
        known = _TYPES.get(_most_frequent(status.get("vehicle_type")), VehicleKind())
        kind = VehicleKind(known.name, known.is_multicopter, firmware)
    return kind


def _most_frequent(values: Floats) -> int:
    """The value that most samples (n,) have, as damage changes some; 0 where there is none."""
    known = values[np.isfinite(values)]
    found, counts = np.unique(known, return_counts=True)
    return int(found[np.argmax(counts)]) if len(found) else 0


def _firmware(read: UlogTopics) -> str | None:
    """Such as "PX4 v1.15.4"."""
    name, version = read.info.get("sys_name"), read.info.get("ver_sw_release")
    if not isinstance(name, str) or not name.isprintable():
        return None
    if not isinstance(version, int):
        return name
    major, minor, patch, stage = version.to_bytes(4, "big") if 0 < version < 1 << 32 else bytes(4)
    told = next(text for least, text in _STAGES if stage >= least)
    return f"{name} v{major}.{minor}.{patch}{told}" if major or minor else name
