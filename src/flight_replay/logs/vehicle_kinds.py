"""Kinds of vehicles, by their MAV_TYPE of MAVLink's common.xml."""

from __future__ import annotations

from dataclasses import dataclass

MULTICOPTERS = {
    2: "quadcopter",
    13: "hexacopter",
    14: "octocopter",
    15: "tricopter",
    29: "dodecacopter",
    35: "decacopter",
}
_OTHERS = {
    1: "fixed wing",
    3: "coaxial helicopter",
    4: "helicopter",
    5: "antenna tracker",
    7: "airship",
    8: "balloon",
    9: "rocket",
    10: "rover",
    11: "boat",
    12: "submarine",
    16: "flapping wing",
    17: "kite",
    19: "tailsitter VTOL",
    20: "tailsitter VTOL",
    21: "tiltrotor VTOL",
    22: "VTOL",
    23: "VTOL",
    24: "VTOL",
    25: "VTOL",
    28: "parafoil",
}


@dataclass(frozen=True, slots=True)
class VehicleKind:
    """A kind of vehicle in words, and its firmware, None where a log does not tell."""

    name: str | None = None
    is_multicopter: bool | None = None
    firmware: str | None = None


def kind_of(mav_type: int, firmware: str | None) -> VehicleKind:
    """The kind of a MAV_TYPE; of one without a meaning nothing is known."""
    if mav_type in MULTICOPTERS:
        return VehicleKind(MULTICOPTERS[mav_type], True, firmware)
    if mav_type in _OTHERS:
        return VehicleKind(_OTHERS[mav_type], False, firmware)
    return VehicleKind(firmware=firmware)
