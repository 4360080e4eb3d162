"""QGC WPL 110, the text file of missions (https://mavlink.io/en/file_formats/).

A header, then one line an item of 12 columns: number, current, frame, command, four parameters,
latitude, longitude, altitude, autocontinue. For ArduPilot line 0 is home, its altitude above mean
sea level, 0 where that is not known; zeros in all three say that home is not. ArduCopter takes a
parameter that is not a number for 0, so that is what is written.
"""

from __future__ import annotations

from flight_replay.exceptions import MissionError
from flight_replay.logs.track import Track
from flight_replay.mission.formats.validation import checked_item, finite
from flight_replay.mission.items import HOME_SEQ, Home, Mission, MissionItem

_HEADER = "QGC WPL 110"
_COLUMNS = 12


def text(mission: Mission, track: Track | None = None, start_utc_s: float | None = None) -> str:
    """The mission with home as item 0 and 8 decimals (1 mm); this format holds no track."""
    items = (mission.home_item, *mission.items)
    lines = [_line(seq, item) for seq, item in enumerate(items, HOME_SEQ)]
    return "\n".join([_HEADER, *lines, ""])


def _line(seq: int, item: MissionItem) -> str:
    numbers = (*item.params, item.lat_deg, item.lon_deg, item.alt_m)
    current = int(seq == HOME_SEQ)
    values = "\t".join(f"{finite(number):.8f}" for number in numbers)
    return f"{seq}\t{current}\t{int(item.frame)}\t{int(item.command)}\t{values}\t1"


def parse(content: str, name: str) -> Mission:
    """The mission in a file's text; errors name the file ``name``.

    Blank lines and lines that begin with # are skipped, as MAVProxy does. The item numbered 0 is
    home whatever its command (Mission Planner writes 0 there).

    Raises:
        MissionError: A line is not what the format says.
    """
    lines = content.splitlines()
    if not lines or lines[0].strip() != _HEADER:
        raise MissionError(f'{name} does not begin with "{_HEADER}"; give a mission in that format')
    rows = [
        _row(line, f"{name} line {number}")
        for number, line in enumerate(lines[1:], 2)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    home = None
    if rows and rows[0][0] == HOME_SEQ:
        home, rows = _home(rows[0][1]), rows[1:]
    return Mission(tuple(item for _, item in rows), home)


def _home(item: MissionItem) -> Home | None:
    known = item.lat_deg != 0 or item.lon_deg != 0
    return Home(item.lat_deg, item.lon_deg, item.alt_m) if known else None


def _row(line: str, where: str) -> tuple[int, MissionItem]:
    columns = line.split()
    if len(columns) != _COLUMNS:
        raise MissionError(
            f"{where} has {len(columns)} columns instead of {_COLUMNS}; correct or delete that line"
        )
    try:
        seq, frame, command = int(columns[0]), int(columns[2]), int(columns[3])
        p1, p2, p3, p4, lat_deg, lon_deg, alt_m = (float(column) for column in columns[4:11])
    except ValueError as error:
        raise MissionError(f"{where} is invalid ({error}); correct or delete that line") from error
    item = MissionItem(command, frame, (p1, p2, p3, p4), lat_deg, lon_deg, alt_m)
    return seq, checked_item(item, where, home=seq == HOME_SEQ)
