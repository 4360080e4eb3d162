"""The rows of a table in CSV, by the names of its columns.

Each line is read by itself, so that a stray quote spoils no other.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Mapping

import numpy as np

from flight_replay.exceptions import LogError
from flight_replay.geometry.arrays import Floats
from flight_replay.logs.tracks.byte_pieces import LogPieces
from flight_replay.logs.tracks.text_values import cells_of, header_cells, number
from flight_replay.logs.tracks.track_points import MOST_POINTS
from flight_replay.writing.counted import counted


class Table:
    """A table that is read once.

    ``header`` are its columns' names; ``notes`` say what of it could not be read.
    """

    def __init__(self, pieces: LogPieces, name: str) -> None:
        self._lines = pieces.lines()
        self.header, self._delimiter = header_cells(self._lines)
        self._name = name
        self.notes: list[str] = []

    def columns(
        self,
        wanted: Mapping[str, tuple[str, Callable[[str], float]]],
        is_row: Callable[[Mapping[str, str]], bool] = lambda _row: True,
        tested: tuple[str, ...] = (),
    ) -> dict[str, Floats]:
        """Columns of numbers (n,), with decimal points or commas.

        Args:
            wanted: For each column to make, the name of the one it is read from and how; ``lat_deg`` and
                ``lon_deg`` are among them.
            is_row: Tells by the cells of the columns ``tested`` whether a row counts.
            tested: Names of columns, all of which there are.

        Raises:
            LogError: There are too many rows.
        """
        at = {name: index for index, name in reversed(list(enumerate(self.header)))}
        taken = [(array("d"), at[source], read) for source, read in wanted.values()]
        place = [at[wanted[name][0]] for name in ("lat_deg", "lon_deg")]
        damaged = 0
        for rows, row in enumerate(cells_of(line, self._delimiter) for line in self._lines if line):
            if len(row) != len(self.header):
                damaged += 1
            elif is_row({name: row[at[name]] for name in tested}):
                # Where places have points, a comma parts thousands.
                has_commas = any("," in row[index] for index in place)
                for column, index, read in taken:
                    column.append(read(row[index].replace(",", ".") if has_commas else row[index]))
            if rows > MOST_POINTS:
                raise LogError(f"{self._name} has more than {MOST_POINTS} rows; cut it, or name another log")
        if damaged:
            self.notes.append(f"Left out: {counted(damaged, 'row')} with more or fewer cells than the header")
        return {name: np.array(column) for name, (column, _, _) in zip(wanted, taken, strict=True)}


def as_number(cell: str) -> float:
    """The number in a cell."""
    return number(cell.strip())
