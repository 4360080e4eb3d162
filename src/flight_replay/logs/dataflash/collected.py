"""Collects what a DataFlash log tells of a flight, block by block.

What comes more often than positions is thinned: of records between two positions, in the order of the
log, only the first and the last count. So memory grows with the positions alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats
from flight_replay.logs.dataflash.logged_vehicle import LoggedVehicle
from flight_replay.logs.dataflash.message_decode import (
    arm_events,
    gps_positions,
    headings,
    home_origins,
    positions,
    velocities,
)
from flight_replay.logs.dataflash.message_rows import MessageRows, Offsets
from flight_replay.logs.dataflash.message_tables import LoggedColumns, LoggedVelocities, TableParts

_POSITIONS: dict[str, Callable[[MessageRows], LoggedColumns | None]] = {
    "POS": positions,
    "GPS": gps_positions,
    "GPS2": gps_positions,
}
_OTHERS: dict[str, tuple[str, Callable[[MessageRows], LoggedColumns | None]]] = {
    "ATT": ("headings", headings),
    "EV": ("events", arm_events),
    "ARM": ("events", arm_events),
    "ORGN": ("homes", home_origins),
}
# Estimators: the velocities' message without and with the number of the core, and the one that tells
# which core is in use. Where NKF1 and XKF1 have no column C they are core 0, and NKF6 and XKF6 core 1.
_VELOCITIES = {"XKF1": ("EKF3", 0), "XKF6": ("EKF3", 1), "NKF1": ("EKF2", 0), "NKF6": ("EKF2", 1)}
_FIRST_ESTIMATOR = "EKF1"  # both the message and the estimator, which has one core
_CORES = {"XKF4": "EKF3", "NKF4": "EKF2"}
ESTIMATORS = ("EKF3", "EKF2", _FIRST_ESTIMATOR)
_TEXTS = {"PARM": "Name", "MSG": "Message", "VER": "FWS"}
MESSAGES = frozenset((*_POSITIONS, *_OTHERS, *_VELOCITIES, _FIRST_ESTIMATOR, *_CORES, *_TEXTS))
"""The messages that are read."""


class Collected:
    """What was read so far: ``tables`` by name, and what the log says of its vehicle.

    The tables are "POS", "GPS", "headings", "events", "homes", and those of ``ESTIMATORS``.
    """

    def __init__(self) -> None:
        self.tables = TableParts()
        self.vehicle = LoggedVehicle()
        self._core = dict.fromkeys(ESTIMATORS, 0.0)

    def add(self, block: Sequence[MessageRows]) -> None:
        """Take the records of a block, which come after all before."""
        places = self._add_positions(block)
        for rows in block:
            if rows.name in _OTHERS:
                name, decode = _OTHERS[rows.name]
                self._add_beside(name, decode(rows), places)
            elif rows.name in _TEXTS:
                self.vehicle.add(rows.text(_TEXTS[rows.name]) or [], rows.number("Value"))
        self._add_velocities(block, places)

    def _add_positions(self, block: Iterable[MessageRows]) -> Offsets:
        """Take the positions; where they are in the log, in order."""
        offsets = [np.zeros(0, np.int64)]
        for rows in block:
            if rows.name in _POSITIONS and (table := _POSITIONS[rows.name](rows)) is not None:
                self.tables.add("POS" if rows.name == "POS" else "GPS", table)
                offsets.append(table.offset)
        return np.sort(np.concatenate(offsets))

    def _add_beside(self, name: str, table: LoggedColumns | None, places: Offsets) -> None:
        """Take those rows of a table that are next to positions in the log."""
        if table is not None and len(table):
            self.tables.add(name, table.select(_are_beside(table.offset, places)))

    def _add_velocities(self, block: Sequence[MessageRows], places: Offsets) -> None:
        """Take the velocities of the cores in use."""
        for rows in block:
            if rows.name == _FIRST_ESTIMATOR:
                self._add_beside(_FIRST_ESTIMATOR, velocities(rows), places)
            elif rows.name in _VELOCITIES and (table := velocities(rows)) is not None:
                estimator, own_core = _VELOCITIES[rows.name]
                core = rows.number("C")
                is_used = self._cores_in_use(estimator, block, table) == (own_core if core is None else core)
                self._add_beside(estimator, table.select(is_used), places)
        for rows in block:
            core = rows.number("PI") if rows.name in _CORES else None
            if core is not None:
                self._core[_CORES[rows.name]] = core[-1]

    def _cores_in_use(self, estimator: str, block: Iterable[MessageRows], table: LoggedVelocities) -> Floats:
        """The core that an estimator used last before each row of a table (n,)."""
        used = np.full(len(table), self._core[estimator])
        for rows in block:
            if _CORES.get(rows.name) == estimator and (core := rows.number("PI")) is not None:
                before = np.searchsorted(rows.offset, table.offset)
                used = np.where(before > 0, core[before - 1], used)
        return used


def _are_beside(offset: Offsets, places: Offsets) -> Flags:
    """Which rows (n,), one at least, are the first or last between two of the places (m,), or of all."""
    gap = np.searchsorted(places, offset)
    changes = gap[1:] != gap[:-1]
    return np.asarray(np.r_[True, changes] | np.r_[changes, True])
