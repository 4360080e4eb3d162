"""A run over logs of every kind, on Dask workers that are threads of this process."""

from __future__ import annotations

import hashlib
import shlex
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from flight_replay.cli.many import many_run
from flight_replay.cli.many.flight_task import flight_row
from flight_replay.cli.many.job import Job
from flight_replay.cli.many.log_content import LogContent
from flight_replay.cli.many.log_files import LogFile, find_logs
from flight_replay.cli.many.many_run import Counts, ManyRun
from flight_replay.cli.many.survey import survey
from flight_replay.cli.options import parse_options
from flight_replay.output.many.flight_columns import COLUMN_OF, Row
from flight_replay.output.many.result_store import ResultStore
from tests.helpers.paths import SAMPLE

distributed = pytest.importorskip("distributed")
pytestmark = pytest.mark.filterwarnings("default")

CUT = 500_000
SHORT = ("--max-points", "10")


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    with (
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


@pytest.fixture
def logs(tmp_path: Path) -> Path:
    """Two different logs, a copy of one, and three that are none."""
    folder = tmp_path / "logs"
    folder.mkdir()
    content = SAMPLE.read_bytes()
    (folder / "a.tlog").write_bytes(content[:CUT])
    (folder / "b.tlog").write_bytes(content[: CUT + 50_000])
    shutil.copy(folder / "a.tlog", folder / "copy.tlog")
    (folder / "empty.tlog").touch()
    (folder / "empty too.tlog").touch()
    (folder / "junk.tlog").write_bytes(b"no log at all" * 100)
    return folder


def run(
    client: Any, folder: Path, out: Path, job: Job, progress: Callable[[Counts], None] = lambda _: None
) -> tuple[list[Row], list[Row]]:
    """The new rows and all rows."""
    new: list[Row] = []
    store = ResultStore(out, job.options_id)
    ManyRun(client, job, store, new.append, progress).run(find_logs([str(folder)], []).files)
    rows = list(store.rows())
    store.close()
    return new, rows


def test_every_log_has_its_row_and_a_second_run_does_nothing(client: Any, logs: Path, tmp_path: Path) -> None:
    job, out = Job(arguments=SHORT), tmp_path / "results.csv"
    new, rows = run(client, logs, out, job)
    assert len(new) == len(rows) == 6
    by_name = {Path(row["log"]).name: row for row in rows}
    assert {name: row["status"] for name, row in by_name.items()} == {
        "a.tlog": "planned",
        "b.tlog": "planned",
        "copy.tlog": "planned",
        "empty.tlog": "unreadable",
        "empty too.tlog": "unreadable",
        "junk.tlog": "unreadable",
    }
    assert {row["copy_of"] for row in rows if "copy_of" in row} == {
        str(logs / "a.tlog"), str(logs / "empty too.tlog"),
    }  # fmt: skip
    assert parse_options(by_name["copy.tlog"]["command"].split()[1:]).log == str(logs / "copy.tlog")
    assert all(row.keys() <= COLUMN_OF.keys() for row in rows)
    assert all("problem" in by_name[name] for name in ("empty.tlog", "junk.tlog"))
    counts: list[Counts] = []
    assert run(client, logs, out, job, counts.append)[0] == []
    assert counts[-1].done_before == 6

    (logs / "c.tlog").write_bytes(SAMPLE.read_bytes()[: CUT + 90_000])
    new, rows = run(client, logs, out, job)
    assert ([Path(row["log"]).name for row in new], len(rows)) == (["c.tlog"], 7)

    other = Job(arguments=(*SHORT, "--altitude", "20"))
    assert len(run(client, logs, out, other)[0]) == 7


def test_a_log_that_workers_do_not_see_is_sent(
    client: Any, logs: Path, tmp_path: Path, monkeypatch: Any
) -> None:
    monkeypatch.setattr(
        LogContent, "is_out_of_sight", property(lambda self: self.sent is None and "a.tlog" in self.file.path)
    )
    monkeypatch.setattr("flight_replay.cli.many.many_run.MOST_SENT_BYTES", CUT)
    for name in ("b.tlog", "copy.tlog", "empty.tlog", "empty too.tlog", "junk.tlog"):
        (logs / name).unlink()
    (logs / "aa.tlog").write_bytes(SAMPLE.read_bytes()[: CUT + 1])
    _, rows = run(client, logs, tmp_path / "sent.csv", Job(arguments=SHORT))
    assert {Path(row["log"]).name: row["status"] for row in rows} == {
        "a.tlog": "planned",
        "aa.tlog": "unreadable",
    }
    assert any("too large to be sent" in row.get("problem", "") for row in rows)


@pytest.mark.parametrize("step", ["survey", "flight_row"])
def test_a_row_of_a_task_that_failed_names_no_machine(
    client: Any, logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    """It is not known here which one it was."""

    def fails(*_: object) -> None:
        raise RuntimeError("as a worker that died")

    monkeypatch.setattr(many_run, step, fails)
    new, _ = run(client, logs / "a.tlog", tmp_path / "failed.csv", Job(arguments=SHORT))
    assert [row["status"] for row in new] == ["internal error"]
    assert "worker" not in new[0]


def test_the_command_of_a_copy_takes_its_path_for_no_option(
    client: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("a.tlog", "-a.tlog"):
        Path(name).write_bytes(b"no log at all" * 100)
        new, _ = run(client, Path(name), Path("results.csv"), Job())
    assert [row["copy_of"] for row in new] == ["a.tlog"]
    assert parse_options(shlex.split(new[0]["command"])[1:]).log == "./-a.tlog"


def one_row(path: Path, job: Job) -> Row:
    """The row of the first flight of a log, without Dask."""
    log = LogContent(LogFile(str(path)))
    found = survey(log, job)
    assert found.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    return flight_row(log, found.sha256, len(found.flights), found.flights[0], job)


@pytest.mark.parametrize("mode", ["auto", "guided"])
def test_the_model_flies_as_it_predicts(mode: str, logs: Path) -> None:
    """The whole flight in the model has the errors that were predicted for it."""
    job = Job(arguments=("--mode", mode, "--duration", "all", "--to", "40"), fly="model")
    row = one_row(logs / "a.tlog", job)
    assert row["status"] == "flown"
    assert row["ended"] == ("recording complete" if mode == "guided" else "mission complete")
    for error in ("path_recorded_to_flown", "position"):
        predicted, flown = (row[f"{prefix}_{error}_mean_m"] for prefix in ("predicted", "flown"))
        assert flown == pytest.approx(predicted, abs=0.05)


def test_the_model_ends_after_the_duration(logs: Path) -> None:
    row = one_row(logs / "a.tlog", Job(arguments=("--duration", "5", "--max-points", "50"), fly="model"))
    assert (row["ended"], row["auto_s"]) == ("duration", 5.0)
    assert row["waypoints_reached"] < row["waypoints"]


def test_what_cannot_be_planned_is_told(logs: Path) -> None:
    row = one_row(logs / "a.tlog", Job(arguments=("--from", "9000")))
    assert row["status"] == "refused"
    assert "--from" in row["problem"]
    assert row["length_m"] > 0
