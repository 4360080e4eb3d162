"""Reads a DataFlash log that was converted to text (``.log``): a line a record, its values in their units."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.logs.byte_source import OpenLog, Progress
from flight_replay.logs.dataflash.collected import MESSAGES, Collected
from flight_replay.logs.dataflash.dataflash_recording import LogContents, dataflash_recording
from flight_replay.logs.dataflash.message_rows import Offsets
from flight_replay.logs.recording import Recording
from flight_replay.logs.vehicles import VehicleId

_PIECE_LENGTH = 4 << 20
_LONGEST_LINE = 4096
_FMT_CELLS = 5  # type, length, name, format and, with commas in it, the columns
_FMT = "FMT"


@np.errstate(invalid="ignore", over="ignore")  # damaged values
def read_dataflash_text(log: OpenLog, _vehicle: VehicleId | None, progress: Progress | None) -> Recording:
    """Read the usable fixes of the one vehicle that wrote a log; see ``log_formats.Read``."""
    lines, collected = _Lines(), Collected()
    for piece in _pieces(log):
        collected.add(lines.read(piece))
        if progress:
            progress(log.position, log.size)
    contents = LogContents(log.name, lines.length, lines.unread, collected, lines.restarts)
    return dataflash_recording(contents)


def _pieces(log: OpenLog) -> Iterator[bytes]:
    """The log in pieces of whole lines; one that has no end is cut."""
    buffer = memoryview(bytearray(_PIECE_LENGTH))
    rest = b""
    while got := log.stream.readinto(buffer):
        data = rest + bytes(buffer[:got])
        end = data.rfind(b"\n") + 1
        if len(data) - end > _LONGEST_LINE:
            end = len(data)
        rest = data[end:]
        yield data[:end]
    yield rest


class TextRows:
    """Records as lines of text have them: a list of cells for each."""

    def __init__(self, name: str, columns: tuple[str, ...]) -> None:
        self.name, self.columns = name, columns
        self._starts: list[int] = []
        self._cells: list[list[bytes]] = []

    def add(self, start: int, line: bytes) -> bool:
        """Take a line's part behind the message's name; whether it has all columns."""
        cells = [cell.strip() for cell in line.split(b",", len(self.columns) - 1)]
        if len(cells) != len(self.columns):
            return False
        self._starts.append(start)
        self._cells.append(cells)
        return True

    @property
    def offset(self) -> Offsets:
        """See ``MessageRows``."""
        return np.array(self._starts, np.int64)

    def number(self, column: str) -> Floats | None:
        """See ``MessageRows``; what is no number in a column is not a number."""
        cells = self.text(column)
        if cells is None or column in _TEXT_COLUMNS:
            return None
        try:
            return np.array(cells, "S").astype(np.float64)
        except ValueError:
            return np.array([_number(cell) for cell in cells])

    def text(self, column: str) -> list[bytes] | None:
        """See ``MessageRows``."""
        if column not in self.columns:
            return None
        index = self.columns.index(column)
        return [cells[index] for cells in self._cells]


_TEXT_COLUMNS = ("Name", "Message", "FWS")


def _number(cell: bytes) -> float:
    try:
        return float(cell)
    except ValueError:
        return float("nan")


class _Lines:
    """Reads lines, with the columns that the FMT lines before them gave."""

    def __init__(self) -> None:
        self.length = self.unread = 0
        self.restarts: list[int] = []
        self._columns: dict[str, tuple[str, ...]] = {}
        names = "|".join(sorted((_FMT, *MESSAGES)))
        self._wanted = re.compile(rf"^({names}),([^\r\n]*)".encode(), re.MULTILINE)

    def read(self, piece: bytes) -> list[TextRows]:
        """The wanted records of whole lines, those with the same columns together."""
        rows: dict[tuple[str, tuple[str, ...]], TextRows] = {}
        for line in self._wanted.finditer(piece):
            name = line[1].decode()
            if name == _FMT:
                self._take_format(self.length + line.start(), line[2])
                continue
            columns = self._columns.get(name, ())
            own = rows.setdefault((name, columns), TextRows(name, columns))
            if not columns or not own.add(self.length + line.start(), line[2]):
                self.unread += len(line[0])
        self.length += len(piece)
        return [each for each in rows.values() if len(each.offset)]

    def _take_format(self, start: int, line: bytes) -> None:
        cells = line.split(b",", _FMT_CELLS - 1)
        if len(cells) < _FMT_CELLS:
            return
        name = cells[2].strip().decode("ascii", "replace")
        if name == _FMT:
            self.restarts.append(start)
        columns = (column.strip() for column in cells[4].decode("ascii", "replace").split(","))
        self._columns[name] = tuple(columns)
