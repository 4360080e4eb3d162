"""The results: every row exactly once, whatever happened before."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from flight_replay.exceptions import FlightReplayError
from flight_replay.output.many.flight_columns import Row
from flight_replay.output.many.result_store import ResultStore, went_wrong
from flight_replay.output.many.table_files import check_table_name, rows_of, write_rows

SUFFIXES = (".csv", ".parquet")


def row(number: int, *, log: str = "a.tlog", sha256: str = "aa", rows: int = 3, **more: object) -> Row:
    return {
        "log": log,
        "log_sha256": sha256,
        "log_bytes": 7,
        "log_modified_ns": 1_700_000_000_123_456_789,
        "log_rows": rows,
        "vehicle_system": 1,
        "vehicle_component": 1,
        "flight": number,
        "status": "planned",
        "fit_for_replay": True,
        "length_m": 12.25,
        "options_id": "x",
        **more,
    }


@pytest.fixture(params=SUFFIXES)
def table(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    if request.param == ".parquet":
        pytest.importorskip("pyarrow")
    return tmp_path / f"results{request.param}"


def test_a_table_gives_back_what_was_written(table: Path) -> None:
    rows = [row(1), row(2, problem='no, "why"\nand more', fit_for_replay=False), row(3, log="ä.tlog")]
    write_rows(table, rows)
    assert list(rows_of(table)) == rows


def test_a_table_that_a_spreadsheet_saved_is_read(tmp_path: Path) -> None:
    table = tmp_path / "results.csv"
    write_rows(table, [row(1), row(2, fit_for_replay=False)])
    table.write_text(table.read_text().replace("true", "TRUE").replace("false", "FALSE"))
    assert [each["fit_for_replay"] for each in rows_of(table)] == [True, False]


@pytest.mark.parametrize("content", ["log,fit_for_replay\na,yes\n", f"log\n{'x' * 200_000}\n"])
def test_what_is_no_table_of_flights_is_refused(tmp_path: Path, content: str) -> None:
    table = tmp_path / "results.csv"
    table.write_text(content)
    with pytest.raises(FlightReplayError, match="is it a table of flights"):
        list(rows_of(table))


def test_nothing_is_left_beside_what_is_no_table(tmp_path: Path) -> None:
    """The file is somebody's, and stays as it is."""
    other = tmp_path / "budget.csv"
    other.write_text("a,b\n1,2\n")
    with pytest.raises(FlightReplayError, match="is it a table of flights"):
        ResultStore(other, "x")
    assert [each.name for each in tmp_path.iterdir()] == ["budget.csv"]
    assert other.read_text() == "a,b\n1,2\n"


def test_rows_are_there_after_the_end(table: Path) -> None:
    store = ResultStore(table, "x")
    store.add(row(1))
    assert [each["flight"] for each in store.rows()] == [1]
    store.add(row(2))
    store.close()
    assert [each["flight"] for each in rows_of(table)] == [1, 2]
    assert [each.name for each in table.parent.iterdir()] == [table.name]


def test_a_crash_loses_the_torn_line_only(table: Path) -> None:
    """What another run left: rows in the table, in the journal, in both, and half a line."""
    write_rows(table, [row(1)])
    journal = table.with_name(f"{table.name}.journal")
    lines = [json.dumps(row(number)) for number in (1, 2)]
    journal.write_text("\n".join(lines) + "\n" + json.dumps(row(3))[:40], encoding="utf-8")
    store = ResultStore(table, "x")
    assert [each["flight"] for each in store.rows()] == [1, 2]
    assert store.found == 2
    assert not store.is_done("a.tlog", 7, 1_700_000_000_123_456_789)
    store.add(row(3))
    store.close()
    assert [each["flight"] for each in rows_of(table)] == [1, 2, 3]


def test_what_is_done_is_known_by_size_time_and_content(table: Path) -> None:
    write_rows(table, [row(number) for number in (1, 2, 3)])
    store = ResultStore(table, "x")
    assert store.is_done("a.tlog", 7, 1_700_000_000_123_456_789)
    assert not store.is_done("a.tlog", 8, 1_700_000_000_123_456_789)
    assert not store.is_done("b.tlog", 7, 1_700_000_000_123_456_789)
    assert store.has_flight("aa", (1, 1, 2))
    assert not store.has_flight("bb", (1, 1, 2))
    store.close()


def test_other_options_are_other_rows(table: Path) -> None:
    write_rows(table, [row(1, rows=1)])
    store = ResultStore(table, "y")
    assert store.found == 0
    store.add(row(1, rows=1, options_id="y"))
    assert len(list(store.rows())) == 1
    store.close()
    assert [each["options_id"] for each in rows_of(table)] == ["x", "y"]


def test_what_failed_is_done_again_if_asked_and_what_was_unreadable_always(table: Path) -> None:
    """Its rows stay until that is done: a run may name other logs."""
    unreadable = {"log": "b.tlog", "options_id": "x", "status": "unreadable", "log_rows": 1}
    write_rows(table, [row(1), row(2, status="failed"), unreadable])
    store = ResultStore(table, "x")
    assert store.found == 2
    assert not store.is_done("b.tlog", None, None)
    store.add(row(1, log="b.tlog", sha256="bb", rows=1))
    store.close()
    store = ResultStore(table, "x", redo=went_wrong)
    assert not store.has_flight("aa", (1, 1, 2))
    store.add(row(3, rows=3))
    assert [(each["log"], each.get("flight"), each["status"]) for each in store.rows()] == [
        ("a.tlog", 1, "planned"),
        ("a.tlog", 2, "failed"),
        ("b.tlog", 1, "planned"),
        ("a.tlog", 3, "planned"),
    ]
    store.add(row(2, status="flown"))
    store.close()
    assert [each["status"] for each in rows_of(table) if each["flight"] == 2] == ["flown"]


def test_a_failed_flight_that_is_done_again_from_another_path_has_one_row(table: Path) -> None:
    """As the same folder by its absolute path; a copy of what failed does not count."""
    write_rows(table, [row(1, rows=1, status="failed")])
    store = ResultStore(table, "x", redo=went_wrong)
    store.add(row(1, rows=1, log="copy.tlog", status="failed", copy_of="a.tlog"))
    store.write()
    assert [each["log"] for each in store.rows()] == ["a.tlog", "copy.tlog"]
    store.add(row(1, rows=1, log="/logs/a.tlog", status="flown"))
    store.close()
    assert [each["log"] for each in rows_of(table)] == ["/logs/a.tlog"]


def test_two_runs_do_not_write_one_table(table: Path) -> None:
    pytest.importorskip("fcntl")
    store = ResultStore(table, "x")
    with pytest.raises(FlightReplayError, match="another run"):
        ResultStore(table, "x")
    store.close()


def test_a_folder_is_no_table(table: Path) -> None:
    """It is refused before a journal is begun beside it."""
    table.mkdir()
    with pytest.raises(FlightReplayError, match="Is a directory; choose another name"):
        check_table_name(table)


def test_other_files_are_no_tables(tmp_path: Path) -> None:
    (tmp_path / "other.csv").write_text("a,b\n1,2\n", encoding="utf-8")
    with pytest.raises(FlightReplayError, match="table of flights"):
        list(rows_of(tmp_path / "other.csv"))
    pytest.importorskip("pyarrow")
    (tmp_path / "other.parquet").write_bytes(b"PAR1 no PAR1")
    with pytest.raises(FlightReplayError, match="table of flights"):
        list(rows_of(tmp_path / "other.parquet"))
