"""Writes DataFlash logs record by record, in bytes and as text, with the columns of several firmwares."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

HEADER = b"\xa3\x95"
# Letters of columns as Python's struct has them, and what a value is multiplied by before it is packed.
_STRUCT = {
    "b": "b", "B": "B", "h": "h", "H": "H", "i": "i", "I": "I", "f": "f", "d": "d", "q": "q", "Q": "Q",
    "n": "4s", "N": "16s", "Z": "64s", "c": "h", "C": "H", "e": "i", "E": "I", "L": "i", "M": "B", "g": "e",
}  # fmt: skip
_FACTORS = {"c": 100, "C": 100, "e": 100, "E": 100, "L": 1e7}
Value = float | int | str

COPTER_4 = {
    "POS": (72, "QLLfff", "TimeUS,Lat,Lng,Alt,RelHomeAlt,RelOriginAlt"),
    "GPS": (90, "QBBIHBcLLeffffB", "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw,U"),
    "ATT": (70, "QccccCCCCB", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw,ErrRP,ErrYaw,AEKF"),
    "XKF1": (44, "QBccCfffffffccce", "TimeUS,C,Roll,Pitch,Yaw,VN,VE,VD,dPD,PN,PE,PD,GX,GY,GZ,OH"),
    "XKF4": (47, "QBcccccfffHBIHb", "TimeUS,C,SV,SP,SH,SM,SVT,errRP,OFN,OFE,FS,TS,SS,GPS,PI"),
    "ARM": (186, "QBIBB", "TimeUS,ArmState,ArmChecks,Forced,Method"),
    "EV": (181, "QB", "TimeUS,Id"),
    "ORGN": (71, "QBLLe", "TimeUS,Type,Lat,Lng,Alt"),
    "MSG": (59, "QZ", "TimeUS,Message"),
    "PARM": (32, "QNff", "TimeUS,Name,Value,Default"),
    "IMU": (20, "QffffffIIfBBHH", "TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz"),
}
"""Types, letters and columns of ArduCopter 4.6."""

COPTER_33 = {
    "GPS": (130, "BIHBcLLeeEefI", "Status,TimeMS,Week,NSats,HDop,Lat,Lng,RelAlt,Alt,Spd,GCrs,VZ,T"),
    "ATT": (1, "IccccCCCC", "TimeMS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw,ErrRP,ErrYaw"),
    "EKF1": (140, "IccCffffffccc", "TimeMS,Roll,Pitch,Yaw,VN,VE,VD,PN,PE,PD,GX,GY,GZ"),
    "EV": (13, "B", "Id"),
    "MSG": (132, "Z", "Message"),
    "PARM": (129, "Nf", "Name,Value"),
}
"""Those of ArduCopter 3.3."""


def fmt(kind: int, length: int, name: str, letters: str, columns: str) -> bytes:
    """An FMT record."""
    return HEADER + struct.pack(
        "<BBB4s16s64s", 128, kind, length, name.encode(), letters.encode(), columns.encode()
    )


@dataclass
class DataflashWriter:
    """A log in the making; ``formats`` are those of a firmware, written at the beginning or when needed.

    ``core`` is that of the estimator in use.
    """

    formats: dict[str, tuple[int, str, str]] = field(default_factory=lambda: dict(COPTER_4))
    late: bool = False
    core: int = 0
    data: bytearray = field(default_factory=bytearray)
    lines: list[str] = field(default_factory=list)
    known: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.begin()

    def begin(self) -> DataflashWriter:
        """Begin a log, as after a boot."""
        self.known = set()
        self._fmt(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
        for name in () if self.late else self.formats:
            self.define(name)
        return self

    def define(self, name: str) -> DataflashWriter:
        """Append the FMT record of a message."""
        kind, letters, columns = self.formats[name]
        self._fmt(kind, self.length(name), name, letters, columns)
        self.known.add(name)
        return self

    def length(self, name: str) -> int:
        """The length of a message's records."""
        return 3 + struct.calcsize("<" + "".join(_STRUCT[letter] for letter in self.formats[name][1]))

    def add(self, name: str, **values: Value) -> DataflashWriter:
        """Append a record; columns that are not given are 0 or empty."""
        if name not in self.known:
            self.define(name)
        kind, letters, columns = self.formats[name]
        packed: list[int | float | bytes] = []
        cells = []
        for column, letter in zip(columns.split(","), letters, strict=True):
            value = values.pop(column, "" if letter in "nNZ" else 0)
            cells.append(str(value))
            if isinstance(value, str):
                packed.append(value.encode())
            elif letter in "fdg":
                packed.append(value)
            else:
                packed.append(round(value * _FACTORS.get(letter, 1)))
        assert not values, f"{name} has no columns {values}"
        code = "<" + "".join(_STRUCT[letter] for letter in letters)
        self.data += HEADER + bytes([kind]) + struct.pack(code, *packed)
        self.lines.append(f"{name}, {', '.join(cells)}")
        return self

    @property
    def text(self) -> bytes:
        """The log as text."""
        return "\r\n".join([*self.lines, ""]).encode()

    def _fmt(self, kind: int, length: int, name: str, letters: str, columns: str) -> None:
        self.data += fmt(kind, length, name, letters, columns)
        self.lines.append(f"FMT, {kind}, {length}, {name}, {letters}, {columns}")

    def fix(
        self, time_s: float, north: int = 0, alt_m: float = 10.0, yaw_deg: float = 90.0, home_m: float = 400.0
    ) -> DataflashWriter:
        """Append what a copter of 4.6 logs ten times a second, ``north`` times 1e-5 degrees from 47.4."""
        time = {"TimeUS": round(time_s * 1e6)}
        self.add("ATT", Yaw=yaw_deg, **time)
        for core in (0, 1):
            self.add("XKF1", C=core, VN=3.0 + 50 * core, VE=-1.0, VD=-0.5, **time)
            self.add("XKF4", C=core, PI=self.core, **time)
        place = {"Lat": 47.4 + north * 1e-5, "Lng": 8.5}
        return self.add("POS", Alt=home_m + alt_m, RelHomeAlt=alt_m, RelOriginAlt=alt_m, **place, **time)

    def receiver(self, time_s: float, north: int = 0, alt_m: float = 10.0, **other: Value) -> DataflashWriter:
        """Append what its receiver tells."""
        values: dict[str, Value] = {
            "TimeUS": round(time_s * 1e6),
            "Status": 3,
            "GMS": round(time_s * 1e3),
            "GWk": 2300,
            "Lat": 47.4 + north * 1e-5,
            "Lng": 8.5,
            "Alt": 400.0 + alt_m,
            "U": 1,
        }
        return self.add("GPS", **{**values, **other})

    def parameter(self, name: str, value: float) -> DataflashWriter:
        """Append a parameter."""
        return self.add("PARM", Name=name, Value=value)

    def arm(self, time_s: float, armed: bool = True) -> DataflashWriter:
        """Append the event of arming or disarming."""
        return self.add("EV", TimeUS=round(time_s * 1e6), Id=10 if armed else 11)

    def home(self, time_s: float) -> DataflashWriter:
        """Append that home was set."""
        return self.add("ORGN", TimeUS=round(time_s * 1e6), Type=1, Lat=47.4, Lng=8.5, Alt=400.0)


def flight(start_s: float = 10.0, fixes: int = 40, late: bool = False) -> DataflashWriter:
    """The log of a flight: armed throughout, with its receiver at every fifth fix."""
    log = DataflashWriter(late=late)
    log.add("MSG", TimeUS=round(start_s * 1e6), Message="ArduCopter V4.6.0 (abcdef01)")
    log.add("MSG", TimeUS=round(start_s * 1e6), Message="Frame: HEXA/X")
    log.parameter("SYSID_THISMAV", 7).parameter("LOG_DISARMED", 0)
    log.home(start_s).arm(start_s)
    for number in range(fixes):
        time_s = start_s + 0.1 * number
        log.add("IMU", TimeUS=round(time_s * 1e6), GyrX=0.1)
        log.fix(time_s, number, yaw_deg=(90.0 + number) % 360)
        if number % 5 == 0:
            log.receiver(time_s, number)
    return log.arm(start_s + 0.1 * fixes, False)
