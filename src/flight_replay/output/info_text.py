"""What a log holds, as lines of text: the file, its vehicle, what was left out, and its flights."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from datetime import datetime, timezone

import numpy as np

from flight_replay.logs.flights import Flight
from flight_replay.logs.log_formats import format_title
from flight_replay.logs.recording import Recording
from flight_replay.logs.vehicles import vehicles_text

_COLUMNS = ("Flight", "Start", "Duration", "Length", "Highest", "Top speed", "Fixes")
_FIRST_WIDTH = 10


def info_lines(recording: Recording, flights: Sequence[Flight]) -> list[str]:
    """The lines; those of the table fit a terminal of 80 columns."""
    lines = [f"{name:<{_FIRST_WIDTH}}{text}" for name, text in _facts(recording)]
    if not flights:
        return [*lines, "", "No flight is found: the vehicle was not armed, or did not move."]
    columns = list(_COLUMNS)
    columns[1] += "" if recording.start_utc_s is None else " (UTC)"
    rows = [tuple(columns), *(_cells(recording, flight) for flight in flights)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(_COLUMNS))]
    table = ["  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
    return [*lines, "", *table]


def _facts(recording: Recording) -> Iterator[tuple[str, str]]:
    """What is known of the log as a whole, name by name."""
    track = recording.track
    yield "Log", recording.path
    yield "Format", f"{format_title(recording.format)}, {_size(recording.bytes)}"
    vehicle = ", ".join(filter(None, [recording.vehicle_type, recording.firmware]))
    if recording.vehicle is not None:
        vehicle = ", ".join(filter(None, [vehicle, f"system {recording.vehicle.id}"]))
    if vehicle:
        yield "Vehicle", vehicle
    others = vehicles_text([each for each in recording.vehicles if each != recording.vehicle])
    if others:
        yield "Others", f"{others}; choose with --vehicle"
    boots = int(np.ptp(track.boot)) + 1
    yield "Fixes", f"{len(track)}" + (f" in {boots} boots" if boots > 1 else "")
    left_out = [f"{count} rejected ({reason})" for reason, count in recording.rejected.items()]
    if recording.without_position:
        left_out.insert(0, f"{recording.without_position} without a position")
    yield "Left out", ", ".join(left_out) or "nothing"
    if recording.start_utc_s is not None:
        yield "Begins", f"{_utc(recording.start_utc_s):%Y-%m-%d %H:%M:%S} UTC"
    for note in recording.notes:
        yield "Note", note


def _cells(recording: Recording, flight: Flight) -> tuple[str, ...]:
    """A row of the table of flights."""
    timed = recording.track.timed
    start = _clock(flight.start_s) if timed else "-"
    if recording.start_utc_s is not None:
        start = f"{_utc(recording.start_utc_s + flight.start_s):%H:%M:%S}"
    return (
        str(flight.number),
        start,
        _clock(flight.end_s - flight.start_s) if timed else "-",
        f"{flight.length_m:.0f} m",
        "-" if flight.highest_m is None else f"{round(flight.highest_m)} m",
        "-" if flight.top_speed_m_s is None else f"{flight.top_speed_m_s:.1f} m/s",
        str(flight.fixes),
    )


def _utc(time_s: float) -> datetime:
    return datetime.fromtimestamp(time_s, timezone.utc)


def _clock(time_s: float) -> str:
    """A time as hours, minutes and seconds, such as 0:09:58."""
    minutes, seconds = divmod(round(time_s), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{seconds:02}"


def _size(count: int) -> str:
    return f"{count / 1e6:.1f} MB" if count >= 1e5 else f"{count / 1e3:.1f} kB"
