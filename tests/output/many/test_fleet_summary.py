"""The summary and the report of many flights."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from flight_replay.exceptions import FlightReplayError
from flight_replay.output.many.fleet_report import check_report_name, save_fleet_report
from flight_replay.output.many.fleet_summary import reason, summary_json, summary_lines, summary_of
from flight_replay.output.many.flight_columns import COLUMNS, Row
from tests.helpers.paths import ROOT

ROWS: list[Row] = [
    {
        "log": f"{number}.tlog",
        "flight": 1,
        "status": "planned",
        "fit_for_replay": True,
        "duration_s": 60.0,
        "length_m": 100.0,
        "start_lat_deg": -35.0 - number,
        "start_lon_deg": 149.0,
        "predicted_position_mean_m": float(number),
        "command": f"flight-replay {number}.tlog --flight 1 --dry-run",
    }
    for number in range(7)
]
ROWS += [
    {"log": name, "status": "unreadable", "problem": f"{name} holds {len(name)} <b>"}
    for name in ("junk1.tlog", "junk22.tlog", "junk333.tlog")
]
ROWS.append({**ROWS[6], "log": "copy.tlog", "copy_of": "6.tlog"})


def test_the_summary_counts_each_flight_once() -> None:
    summary = summary_json(summary_of(ROWS))
    assert (summary["rows"], summary["copies"]) == (11, 1)
    assert summary["statuses"] == {"planned": 7, "unreadable": 3}
    assert summary["reasons"] == {"LOG holds N <b>": 3}
    error = summary["errors"]["predicted_position_mean_m"]
    assert (error["flights"], error["median"]) == (7, 3.0)
    assert [each["error"] for each in error["worst"]] == [6.0, 5.0, 4.0, 3.0, 2.0]
    assert any("3 x LOG holds N" in line for line in summary_lines(summary_of(ROWS)))


def test_numbers_in_addresses_are_no_reason_to_tell_failures_apart() -> None:
    """They are kept, and what is counted or measured is not."""
    text = "cannot download from https://s3.host.com/copter4.tar.gz: 12 s passed, 0.5 of -3 files"
    kept = "cannot download from https://s3.host.com/copter4.tar.gz: N s passed, N of N files"
    assert reason({"log": "a.tlog", "problem": text}) == kept


def test_the_report_is_one_file_that_shows_all(tmp_path: Path) -> None:
    pytest.importorskip("bokeh")
    save_fleet_report(tmp_path / "fleet.html", iter(ROWS), "flight-replay-many logs")
    page = (tmp_path / "fleet.html").read_text(encoding="utf-8")
    assert "flight-replay 6.tlog --flight 1 --dry-run" in page
    assert "LOG holds N &lt;b&gt;" in page
    head = page[: page.index("<body>")]
    assert not re.search(r"<(script|link)[^>]*(src|href)=", head)
    assert "Where the flights were" in page


def test_a_report_without_places_has_no_map(tmp_path: Path) -> None:
    pytest.importorskip("bokeh")
    save_fleet_report(tmp_path / "fleet.html", iter(ROWS[7:10]), "flight-replay-many logs")
    assert "Where the flights were" not in (tmp_path / "fleet.html").read_text(encoding="utf-8")


def test_the_docs_list_every_column() -> None:
    """Names and meanings are the same in docs/many.md."""
    text = (ROOT / "docs" / "many.md").read_text(encoding="utf-8")
    listed = [line.split("|")[1:4] for line in text.splitlines() if line.startswith("| `")]
    columns = [[f" `{each.name}` ", f" {each.kind} ", f" {each.meaning} "] for each in COLUMNS]
    assert [row for row in listed if row in columns] == columns


def test_a_report_that_exists_is_replaced_by_the_command_that_made_it_alone(tmp_path: Path) -> None:
    """The same command goes on where it was stopped, and was complete."""
    page, command = (
        tmp_path / "fleet.html",
        "flight-replay-many 'log <1> & \"2\"' --report fleet.html --force",
    )
    check_report_name(page, command, replace=False)
    save_fleet_report(page, iter(ROWS[:1]), command)
    check_report_name(page, command, replace=False)
    with pytest.raises(FlightReplayError, match="exists; choose another name, or replace it"):
        check_report_name(page, "flight-replay-many logs", replace=False)
    check_report_name(page, "flight-replay-many logs", replace=True)
