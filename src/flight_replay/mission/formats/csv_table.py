"""CSV: one table, one row an item or a fix, told apart by the column ``kind`` (home, item, track).

A cell is empty where its row's kind has no such value. What was recorded is there to the millimetre
and the microsecond, the time of day to the millisecond: ``logs/tracks/saved_csv.py`` reads the same
track again. Lines end in LF, numbers use a point.
"""

from __future__ import annotations

import csv
import io
import math

from flight_replay.logs.track import Track
from flight_replay.mission.formats.item_text import amsl_m, command_name, utc_texts
from flight_replay.mission.items import FIRST_SEQ, HOME_SEQ, Mission

_ITEM = ("kind", "seq", "command", "command_name", "frame", "param1", "param2", "param3", "param4")
_PLACE = ("lat_deg", "lon_deg", "alt_m", "amsl_m")
_FIX = ("time_s", "north_m_s", "east_m_s", "up_m_s", "boot", "armed", "heading_deg", "utc")
COLUMNS = _ITEM + _PLACE + _FIX


def text(mission: Mission, track: Track | None = None, start_utc_s: float | None = None) -> str:
    """The mission, and the recorded track if there is one.

    Its fixes have the time of day with ``start_utc_s``, the Unix time of the first.
    """
    page = io.StringIO()
    writer = csv.DictWriter(page, COLUMNS, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(_mission_rows(mission))
    if track is not None:
        writer.writerows(_track_rows(track, start_utc_s))
    return page.getvalue()


def _mission_rows(mission: Mission) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = []
    if mission.home is not None:
        home = mission.home
        place = (home.lat_deg, home.lon_deg, 0.0, home.amsl_m)
        rows.append({"kind": "home", "seq": HOME_SEQ, **_place(*place)})
    for seq, item in enumerate(mission.items, FIRST_SEQ):
        row: dict[str, object] = {"kind": "item", "seq": seq, "command": int(item.command)}
        row |= {"command_name": command_name(item), "frame": int(item.frame)}
        row |= {f"param{n}": _number(value, 8) for n, value in enumerate(item.params, 1)}
        rows.append(row | _place(item.lat_deg, item.lon_deg, item.alt_m, amsl_m(item, mission.home)))
    return rows


def _track_rows(track: Track, start_utc_s: float | None) -> list[dict[str, object]]:
    is_dated = track.timed and start_utc_s is not None
    times = utc_texts(track, start_utc_s or 0.0) if is_dated else [""] * len(track)
    return [
        {
            "kind": "track",
            **_place(
                float(track.lat_deg[n]),
                float(track.lon_deg[n]),
                float(track.alt_m[n]),
                float(track.amsl_m[n]),
            ),
            "time_s": _number(float(track.time_s[n]), 6) if track.timed else "",
            "north_m_s": _number(float(track.north_m_s[n]), 3),
            "east_m_s": _number(float(track.east_m_s[n]), 3),
            "up_m_s": _number(float(track.up_m_s[n]), 3),
            "boot": int(track.boot[n]),
            "armed": int(track.armed[n]),
            "heading_deg": _number(float(track.heading_deg[n]), 3),
            "utc": times[n],
        }
        for n in range(len(track))
    ]


def _place(lat_deg: float, lon_deg: float, alt_m: float, height_m: float) -> dict[str, object]:
    return {
        "lat_deg": _number(lat_deg, 8),
        "lon_deg": _number(lon_deg, 8),
        "alt_m": _number(alt_m, 3),
        "amsl_m": _number(height_m, 3),
    }


def _number(value: float, decimals: int) -> str:
    if not math.isfinite(value):
        return ""
    whole = round(value, decimals) + 0.0  # no "-0"
    return f"{whole:.{decimals}f}".rstrip("0").rstrip(".")
