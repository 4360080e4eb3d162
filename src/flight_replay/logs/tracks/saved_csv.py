"""The table that ``--save FILE.csv`` writes: the rows whose ``kind`` is "track" are the fixes of a flight."""

from __future__ import annotations

from collections.abc import Callable

from flight_replay.logs.byte_source import OpenLog, Progress
from flight_replay.logs.recording import Recording
from flight_replay.logs.track import COLUMNS
from flight_replay.logs.tracks.byte_pieces import LogPieces
from flight_replay.logs.tracks.recorded_columns import columns_recording
from flight_replay.logs.tracks.table_rows import Table, as_number
from flight_replay.logs.tracks.text_values import unix_time_s
from flight_replay.logs.tracks.track_recording import TrackFile
from flight_replay.logs.vehicles import VehicleId


def read_saved_csv(log: OpenLog, _vehicle: VehicleId | None, progress: Progress | None) -> Recording:
    """Read a table that was saved; see ``log_formats.Read``."""
    pieces = LogPieces(log, progress)
    table = Table(pieces, log.name)
    wanted: dict[str, tuple[str, Callable[[str], float]]] = {
        name: (name, as_number) for name in COLUMNS if name in table.header
    }
    if "utc" in table.header:
        wanted["utc"] = ("utc", unix_time_s)
    columns = table.columns(wanted, lambda row: row["kind"] == "track", ("kind",))
    file = TrackFile(name=log.name, bytes=pieces.count, notes=table.notes)
    return columns_recording(columns, file, columns.get("utc"))
