"""Runs that are killed, interrupted, or lose their workers: in processes of their own, as users run them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import pytest

from flight_replay.output.many.flight_columns import Row
from flight_replay.output.many.table_files import rows_of
from tests.helpers.paths import SAMPLE

pytest.importorskip("distributed")
pytestmark = pytest.mark.slow

MANY = [
    sys.executable, "-c", "import sys; from flight_replay.cli.many.many_main import main; sys.exit(main())"
]  # fmt: skip
SHORT = ["--max-points", "10", "-q"]
LIMIT_S = 300.0
needs_proc = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks for processes in /proc")


@pytest.fixture
def logs(tmp_path: Path) -> Path:
    """Forty logs that differ."""
    folder = tmp_path / "logs"
    folder.mkdir()
    content = SAMPLE.read_bytes()
    for number in range(40):
        (folder / f"{number:02}.tlog").write_bytes(content[: 400_000 + 1000 * number])
    return folder


@contextmanager
def started(command: list[str], **more: object) -> Iterator[subprocess.Popen[bytes]]:
    """A process that does not outlive the test."""
    process = subprocess.Popen(command, start_new_session=True, **more)  # type: ignore[call-overload]
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def wait_for(condition: Callable[[], bool]) -> None:
    end_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < end_s
        time.sleep(0.05)


def rows_waiting(out: Path) -> int:
    """How many rows are in the journal."""
    journal = out.with_name(f"{out.name}.journal")
    return journal.read_bytes().count(b"\n") if journal.exists() else 0


def children(process: int) -> list[int]:
    """Dask's workers that a process has started; any of its threads may have."""
    found = []
    for task in Path(f"/proc/{process}/task").iterdir():
        with suppress(OSError):  # A thread or a child may end meanwhile.
            for child in (task / "children").read_text(encoding="ascii").split():
                if b"resource_tracker" not in Path(f"/proc/{child}/cmdline").read_bytes():
                    found.append(int(child))
    return found


def address_in(scheduler_file: Path) -> str | None:
    """The address in Dask's file, once the file is there and whole: Dask writes it in pieces."""
    try:
        return str(json.loads(scheduler_file.read_text(encoding="utf-8"))["address"])
    except (FileNotFoundError, json.JSONDecodeError):
        return None


def check_all(out: Path, logs: Path) -> list[Row]:
    """Every log has its rows, each once."""
    rows = list(rows_of(out))
    assert sorted({row["log"] for row in rows}) == sorted(str(path) for path in logs.iterdir())
    assert set(Counter((row["log"], row.get("flight")) for row in rows).values()) == {1}
    return rows


def test_a_run_that_is_killed_again_and_again_loses_and_doubles_nothing(logs: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.csv"
    command = [*MANY, str(logs), "--out", str(out), *SHORT]
    for _ in range(3):
        with started(command) as run:
            wait_for(lambda: rows_waiting(out) > 1 or run.poll() is not None)
    assert subprocess.run(command, timeout=LIMIT_S, check=False).returncode == 0
    assert {row["status"] for row in check_all(out, logs)} == {"planned"}


@needs_proc
def test_ctrl_c_ends_all_processes_in_seconds_and_keeps_what_is_done(logs: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.csv"
    with started([*MANY, str(logs), "--out", str(out), *SHORT], stderr=subprocess.PIPE) as run:
        wait_for(lambda: rows_waiting(out) > 1)
        workers = children(run.pid)
        assert workers
        os.killpg(run.pid, signal.SIGINT)
        _, told = run.communicate(timeout=30)
    assert run.returncode == 130
    assert told.decode().count("\n") == 1
    assert b"goes on" in told
    assert len(list(rows_of(out))) > 1
    wait_for(lambda: not any(Path(f"/proc/{worker}").exists() for worker in workers))


@needs_proc
def test_a_worker_that_dies_costs_nothing_and_one_that_hangs_its_flight(logs: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.csv"
    with started([*MANY, str(logs), "--out", str(out), *SHORT, "--workers", "2"]) as run:
        wait_for(lambda: rows_waiting(out) > 1)
        os.kill(children(run.pid)[-1], signal.SIGKILL)
        assert run.wait(LIMIT_S) == 0
    assert {row["status"] for row in check_all(out, logs)} == {"planned"}

    late = [*MANY, str(logs / "00.tlog"), "--out", str(out), "--time-limit", "0.05", "-q", "--route", "fit"]
    assert subprocess.run(late, timeout=LIMIT_S, check=False).returncode == 0
    lost = [row for row in rows_of(out) if row["status"] == "worker lost"]
    assert len(lost) == 1
    assert "took longer than 0 s" in lost[0]["problem"]


def test_workers_of_a_cluster_come_and_go(logs: Path, tmp_path: Path) -> None:
    out, address_file = tmp_path / "out.csv", tmp_path / "scheduler.json"
    dask = [sys.executable, "-W", "ignore", "-m", "dask"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": tmp_path}
    scheduler = [*dask, "scheduler", "--port", "0", "--no-dashboard", "--host", "127.0.0.1"]
    with ExitStack() as stack:
        stack.enter_context(started([*scheduler, "--scheduler-file", str(address_file)], **quiet))
        wait_for(lambda: address_in(address_file) is not None)
        address = address_in(address_file) or ""
        worker = [*dask, "worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
        stack.enter_context(started(worker, **quiet))
        doomed = stack.enter_context(started(worker, **quiet))
        command = [*MANY, str(logs), "--scheduler", address, "--out", str(out), *SHORT]
        run = stack.enter_context(started(command))
        wait_for(lambda: rows_waiting(out) > 1)
        doomed.kill()
        stack.enter_context(started(worker, **quiet))
        assert run.wait(LIMIT_S) == 0
    assert {row["status"] for row in check_all(out, logs)} == {"planned"}
