"""CSV: one table of home, items and fixes."""

import csv
from dataclasses import replace
from pathlib import Path

from flight_replay.mission import formats
from flight_replay.mission.items import Mission, MissionItem
from tests.helpers.format_examples import HOME, MISSION, recorded_track


def test_csv_is_one_table_told_apart_by_kind(tmp_path: Path) -> None:
    """Home, items and fixes are rows; what a row cannot have is an empty cell."""
    path = tmp_path / "mission.csv"
    formats.save(path, MISSION, recorded_track())
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["kind"] for row in rows] == ["home"] + ["item"] * 6 + ["track"] * 4
    assert (rows[3]["seq"], rows[3]["command_name"], rows[3]["param1"]) == ("3", "spline waypoint", "2")
    assert (rows[3]["lat_deg"], rows[3]["alt_m"], rows[3]["amsl_m"]) == ("47.39794213", "31.5", "519.75")
    assert (rows[2]["command_name"], rows[2]["param2"], rows[2]["amsl_m"]) == ("change speed", "4.25", "")
    assert (rows[9]["amsl_m"], rows[9]["north_m_s"], rows[10]["alt_m"]) == ("", "", "0")


def test_unknown_heights_above_the_sea_are_empty_cells() -> None:
    """Neither home nor an item above it has one then."""
    mission = MISSION.with_home(replace(HOME, alt_amsl_m=None))
    rows = list(csv.DictReader(formats.csv_table.text(mission).splitlines()))
    assert [row["amsl_m"] for row in rows] == ["", "", "", "", "", "520", ""]
    assert [row["alt_m"] for row in rows[:2]] == ["0", "30"]


def test_a_command_without_a_word_is_its_number() -> None:
    """Nothing is lost of a mission that another program made."""
    mission = Mission((MissionItem(206, 2, (25.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0),))
    assert "command 206" in formats.csv_table.text(mission)
    assert "item" not in formats.csv_table.text(Mission(()))
