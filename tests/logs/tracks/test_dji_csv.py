"""Tables of DJI flights, in the units of any place."""

import re

import numpy as np
import pytest

from flight_replay.exceptions import LogError
from flight_replay.logs.track import COLUMNS, Armed
from tests.helpers.track_files import START_S, kind_of_bytes, read_bytes

FEET, MPH = 0.3048, 0.44704


def airdata(*, metric: bool = False, step_ms: int = 100, name: str = "height_above_takeoff") -> bytes:
    """Ten seconds northwards at 5 m/s, 20 m above home and 220 m above the sea, sinking with 1 m/s."""
    length, speed = ("meters", "m/s") if metric else ("feet", "mph")
    metres, m_s = (1.0, 1.0) if metric else (FEET, MPH)
    lines = [
        f"time(millisecond),datetime(utc),latitude,longitude,{name}({length}),"
        f"altitude_above_seaLevel({length}), xSpeed({speed}), ySpeed({speed}), zSpeed({speed}),"
        "compass_heading(degrees),flycState,message"
    ]
    for n in range(100):
        row = (
            n // 2 * 2 * step_ms if step_ms == 50 else n * step_ms,
            f"2026-03-01 10:00:{n // 10:02}",
            47.0 + n * 0.5 / 111_170,
            8.0,
            (20.0 - n / 10) / metres,
            (220.0 - n / 10) / metres,
            5.0 / m_s,
            0.0,
            1.0 / m_s,
            188.4,
            "P-GPS",
            '"a, b"' if n == 3 else "",
        )
        lines.append(",".join(map(str, row)))
    return "\n".join(lines).encode()


@pytest.mark.parametrize("metric", [False, True])
def test_airdata_is_read_in_its_units(metric: bool) -> None:
    """Feet and miles an hour, or metres."""
    recording = read_bytes(airdata(metric=metric))
    track = recording.track
    assert (recording.format, recording.start_utc_s) == ("airdata", START_S)
    assert track.time_s == pytest.approx(np.arange(100) / 10)
    assert track.alt_m[[0, 50]] == pytest.approx([20.0, 15.0])
    assert track.amsl_m[0] == pytest.approx(220.0)
    assert (track.north_m_s[0], track.east_m_s[0], track.up_m_s[0]) == pytest.approx((5.0, 0.0, -1.0))
    assert track.heading_deg[0] == 188.4
    assert (track.armed == Armed.YES).all()


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
def test_lines_end_as_any_program_ends_them(end: bytes) -> None:
    """Excel has a format with carriage returns alone."""
    assert len(read_bytes(airdata().replace(b"\n", end)).track) == 100


@pytest.mark.parametrize("stray", [b'"', b"\r", b","])
def test_a_stray_character_costs_its_own_row(stray: bytes) -> None:
    """Not what follows it."""
    lines = airdata().split(b"\n")
    lines[50] = stray + lines[50] if stray == b'"' else lines[50].replace(b",P-", stray + b",P-")
    recording = read_bytes(b"\n".join(lines))
    assert len(recording.track) == 99
    rows = "2 rows" if stray == b"\r" else "1 row"
    assert recording.notes[0] == f"Left out: {rows} with more or fewer cells than the header"


def test_a_table_in_a_single_column_is_no_table_of_a_flight() -> None:
    """As spreadsheets save it that part cells by another character; the columns are told."""
    lines = (b'"' + line.replace(b'"', b'""') + b'"' for line in airdata().split(b"\n"))
    with pytest.raises(LogError, match="is a table without the columns"):
        read_bytes(b"\n".join(lines))


def test_heights_of_older_tables_have_other_names() -> None:
    """Of the names that are known the first is read that there is."""
    table = airdata(name="ascent").replace(b"altitude_above_seaLevel", b"altitude")
    track = read_bytes(table).track
    assert track.alt_m[[0, 50]] == pytest.approx([20.0, 15.0])
    assert track.amsl_m[0] == pytest.approx(220.0)


def test_airdata_rows_with_the_same_time_are_spread() -> None:
    """Some of its tables repeat a time."""
    assert read_bytes(airdata(step_ms=50)).track.time_s == pytest.approx(np.arange(100) / 20)


@pytest.mark.parametrize("begin", [b"\xef\xbb\xbf", b"sep=,\r\n"])
def test_what_excel_needs_does_not_matter(begin: bytes) -> None:
    """A byte order mark, or a line that says what parts the cells."""
    assert len(read_bytes(begin + airdata()).track) == 100


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_spreadsheets_of_any_language_may_save_the_table(delimiter: str, encoding: str) -> None:
    """Where numbers have commas, semicolons or tabs part them."""
    changed = airdata().decode().replace(",", delimiter).replace(".", ",").encode(encoding)
    track, wanted = read_bytes(changed).track, read_bytes(airdata()).track
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(track, name), getattr(wanted, name), err_msg=name)


def test_commas_that_part_thousands_are_no_decimal_points() -> None:
    """Where places have points, such numbers are not known, here most times."""
    table = airdata().decode().replace(",", ";")
    header, *rows = table.splitlines()
    changed = [re.sub(r"^(\d+)(\d{3});", r"\1,\2;", row) for row in rows]
    assert changed != rows
    assert not read_bytes("\n".join([header, *changed]).encode()).track.timed


def test_a_unit_that_is_not_known_is_refused() -> None:
    """Rather than taken for another."""
    with pytest.raises(LogError, match=r"has xSpeed\(furlongs\) in a unit that is not known"):
        read_bytes(airdata().replace(b"xSpeed(mph)", b"xSpeed(furlongs)"))


def test_tables_of_csvview_and_phantomhelp_are_read() -> None:
    """Names of DJI's own records, units in brackets."""
    header = "OSD.flyTime [s],OSD.latitude,OSD.longitude,OSD.height [ft],OSD.yaw [360],OSD.isMotorUp"
    rows = [f"{n / 10},{47 + n * 5e-6},8,{n / FEET},90.5,{n > 5}" for n in range(50)]
    data = "\n".join([header, *rows]).encode()
    assert kind_of_bytes(data) == "dji-csv"
    track = read_bytes(data).track
    assert track.time_s[-1] == pytest.approx(4.9)
    assert track.alt_m[-1] == pytest.approx(49.0)
    assert track.armed[[5, 6]].tolist() == [Armed.NO, Armed.YES]
    assert track.north_m_s[25] == pytest.approx(5.56, abs=0.01)
    minutes = read_bytes(data.replace(b"OSD.flyTime [s]", b"OSD.flyTime").replace(b"\n4.9,", b"\n1m 4.9s,"))
    assert minutes.track.time_s[-1] == pytest.approx(64.9)


@pytest.mark.parametrize(("version", "why"), [(14, "encrypted by DJI"), (6, "not read here")])
def test_a_dji_flight_record_says_what_to_do(version: int, why: str) -> None:
    """AirData reads it."""
    data = (
        (100_000).to_bytes(8, "little")
        + (700).to_bytes(2, "little")
        + bytes([version])
        + bytes(89)
        + b"\1\2" * 99
    )
    with pytest.raises(LogError, match=f"version {version}, {why}; upload it to airdata.com"):
        read_bytes(data)
