"""Which vehicle wrote a DataFlash log, by its parameters and messages."""

from __future__ import annotations

import re
from collections.abc import Sequence

from flight_replay.geometry.arrays import Floats
from flight_replay.logs.vehicle_kinds import VehicleKind, kind_of

_PARAMETERS = (
    b"SYSID_THISMAV",
    b"MAV_SYSID",  # its name from 4.7 on
    b"LOG_DISARMED",
    b"AHRS_EKF_TYPE",
    b"FRAME_CLASS",
    b"Q_ENABLE",
)
_BANNER = re.compile(rb"(?:(?:Ardu|APM:)?(Copter|Plane|Rover|Sub)|(AntennaTracker|Blimp)) [Vv]\d[\w.-]{0,40}")
_FRAME = re.compile(rb"Frame: ([A-Z0-9_]+)")
_MOST_BANNERS = 8
_MAV_TYPES = {b"Plane": 1, b"Rover": 10, b"Sub": 12, b"AntennaTracker": 5, b"Blimp": 7}
_VTOL = 22
# MAV_TYPE by the words of the message "Frame: ..." and by the parameter FRAME_CLASS of ArduCopter.
_FRAMES = {
    b"QUAD": 2,
    b"HEXA": 13,
    b"Y6": 13,
    b"OCTA": 14,
    b"OCTA_QUAD": 14,
    b"OCTAQUAD": 14,
    b"TRI": 15,
    b"HELI": 4,
    b"HELI_DUAL": 4,
    b"HELI_QUAD": 4,
    b"DODECA_HEXA": 29,
    b"DECA": 35,
    b"SINGLE": 3,
    b"COAX": 3,
}
_FRAME_CLASSES = {1: 2, 2: 13, 3: 14, 4: 14, 5: 13, 6: 4, 7: 15, 8: 3, 9: 3, 11: 4, 12: 29, 13: 4, 14: 35}


class LoggedVehicle:
    """What a log says of its vehicle: ``firmwares`` in the order in which they are named."""

    def __init__(self) -> None:
        self.firmwares: list[str] = []
        self._product: bytes | None = None
        self._frame: bytes | None = None
        self._parameters: dict[bytes, float] = {}

    def add(self, texts: Sequence[bytes], values: Floats | None) -> None:
        """Take records: parameters by their names and values, or messages."""
        if values is None:
            for text in texts:
                self._add_message(text)
            return
        for name in _PARAMETERS:
            if name in texts:
                last = len(texts) - 1 - texts[::-1].index(name)
                self._parameters[name] = float(values[last])

    def _add_message(self, text: bytes) -> None:
        if frame := _FRAME.match(text):
            self._frame = frame[1]
        elif banner := _BANNER.match(text):
            name = banner[0].decode("ascii")
            if name not in self.firmwares and len(self.firmwares) < _MOST_BANNERS:
                self.firmwares.append(name)
            self._product = self._product or banner[1] or banner[2]

    @property
    def system_id(self) -> int | None:
        """Its MAVLink system id."""
        number = self._parameters.get(b"MAV_SYSID", self._parameters.get(b"SYSID_THISMAV", 0.0))
        return int(number) if 1 <= number <= 255 else None

    @property
    def logs_when_disarmed(self) -> bool | None:
        """Whether it logs while disarmed, None where the log does not tell."""
        number = self._parameters.get(b"LOG_DISARMED")
        return None if number is None else number != 0

    @property
    def estimator(self) -> str | None:
        """The estimator that its parameters choose."""
        return {1: "EKF1", 2: "EKF2", 3: "EKF3"}.get(int(self._number(b"AHRS_EKF_TYPE")))

    @property
    def kind(self) -> VehicleKind:
        """Which kind of vehicle it is; a copter of a frame that is not told is some multicopter."""
        firmware = self.firmwares[0] if self.firmwares else None
        if self._product in _MAV_TYPES:
            is_vtol = self._product == b"Plane" and self._number(b"Q_ENABLE") > 0
            return kind_of(_VTOL if is_vtol else _MAV_TYPES[self._product], firmware)
        frame = _FRAME_CLASSES.get(int(self._number(b"FRAME_CLASS"))) or _FRAMES.get(self._frame or b"")
        if self._product != b"Copter":
            return VehicleKind(firmware=firmware)
        return VehicleKind("multicopter", True, firmware) if frame is None else kind_of(frame, firmware)

    def _number(self, name: bytes) -> float:
        """A parameter's value, 0 where it is not known or no number that one could have."""
        value = self._parameters.get(name, 0.0)
        return value if abs(value) < 1e6 else 0.0
