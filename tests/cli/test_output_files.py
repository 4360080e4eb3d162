"""Output files of the command line: never an input, never lost, and no reason to lose the results."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from html import unescape
from pathlib import Path

import pytest

from flight_replay.cli.main import main
from tests.helpers.paths import SAMPLE

DRY = ["--dry-run", "--json"]


@pytest.fixture
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A log of one's own in the current folder."""
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copy(SAMPLE, tmp_path / "mine.tlog"))


@pytest.mark.parametrize("link", ["itself", "symbolic", "hard"])
@pytest.mark.parametrize("force", [[], ["--force"]], ids=["plain", "forced"])
def test_the_log_that_is_replayed_is_never_written(
    log: Path, link: str, force: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    """Under no name, and not with --force either; it keeps every byte."""
    before = log.read_bytes()
    target = log
    if link != "itself":
        target = log.with_name("other.tlog")
        (target.symlink_to if link == "symbolic" else target.hardlink_to)(log)
    assert main(["--tlog", str(log), "--record", str(target), *DRY, *force]) == 1
    assert "is the log that is replayed" in capsys.readouterr().err
    assert log.read_bytes() == before


@pytest.mark.parametrize("role", ["read", "written"])
def test_a_link_to_itself_is_one_clear_error(
    role: str, log: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Whether it is the log or an output."""
    link = Path("loop.csv")
    link.symlink_to(link)
    arguments = [str(link), *DRY] if role == "read" else [str(log), "--save", str(link), *DRY]
    assert main(arguments) == 1
    (error,) = [line for line in capsys.readouterr().err.splitlines() if "error" in line]
    assert "loop.csv" in error
    assert "symbolic links" in error


def test_no_file_is_written_twice(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Two options with one file would leave only one of the two."""
    assert main(["--tlog", str(log), "--save", "a.kml", "--save", "./a.kml", *DRY]) == 1
    assert "a.kml is written by another option; choose" in capsys.readouterr().err
    assert not Path("a.kml").exists()
    Path("b.kml").symlink_to("a.kml")
    assert main(["--tlog", str(log), "--save", "a.kml", "--save", "b.kml", *DRY]) == 1
    assert "b.kml is written by another option, as a.kml; choose" in capsys.readouterr().err


def test_a_file_that_exists_is_replaced_only_with_force(
    log: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The refusal comes before anything is read, and names the option."""
    Path("a.plan").write_text("mine")
    assert main(["--tlog", str(log), "--save", "a.plan", *DRY]) == 1
    assert "a.plan exists; choose another name, or replace it with --force" in capsys.readouterr().err
    assert Path("a.plan").read_text() == "mine"
    assert main(["--tlog", str(log), "--save", "a.plan", "--force", *DRY]) == 0
    assert Path("a.plan").read_text() != "mine"


@pytest.mark.parametrize(
    "output", [["--save", "a.kml"], ["--record", "a.tlog"], ["--plot", "a.png"], ["--report", "a.html"]]
)
def test_a_folder_is_no_output(
    log: Path, output: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The refusal comes before anything is read or flown, not after the flight."""
    monkeypatch.setattr("flight_replay.cli.plan_step.read_recording", None)
    Path(output[1]).mkdir()
    assert main(["--tlog", str(log), *output, "--force"]) == 1
    assert f"cannot write {output[1]}: Is a directory; choose another name" in capsys.readouterr().err


def test_the_command_in_a_report_can_be_run(log: Path) -> None:
    """As it is printed there, though the report is there by then."""
    assert main(["--tlog", str(log), "--report", "a.html", *DRY]) == 0
    page = Path("a.html").read_text(encoding="utf-8")
    (command,) = re.findall("<pre>flight-replay (.*)</pre>", page)
    assert main(shlex.split(unescape(command))) == 0


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
@pytest.mark.parametrize("output", [["--save", "a.kml"], ["--plot", "a.png"], ["--report", "a.html"]])
def test_a_pipe_is_no_output(log: Path, output: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """A file would take its place; only recordings are written to one."""
    os.mkfifo(output[1])
    assert main(["--tlog", str(log), *output, "--force", *DRY]) == 1
    error = f"flight-replay: error: {output[1]} is not a regular file; choose another name\n"
    assert capsys.readouterr().err == error
    assert Path(output[1]).is_fifo()


@pytest.mark.parametrize(
    "error", [OSError(28, "No space left on device"), ValueError("no font"), MemoryError()]
)
def test_a_plot_that_fails_costs_neither_the_results_nor_the_report(
    log: Path, error: Exception, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The JSON object came before it, the report is written, exit status and error line tell of it."""
    results: list[str] = []

    def fail(*_: object) -> None:
        results.append(capsys.readouterr().out)
        raise error

    monkeypatch.setattr("flight_replay.output.charts.plot.save_plot", fail)
    assert main(["--tlog", str(log), "--plot", "a.png", "--report", "a.html", *DRY]) == 1
    output = capsys.readouterr()
    assert json.loads(results[0])["route"]["points"] == 100
    assert output.err.count("flight-replay: error: ") == 1
    assert "a.png" in output.err
    assert Path("a.html").exists()


@pytest.mark.parametrize("verbose", [False, True])
def test_only_with_v_the_log_says_why_a_plot_failed(log: Path, tmp_path: Path, verbose: bool) -> None:
    """Where nobody set logging up, as in a program of its own."""
    code = (
        "import sys; from flight_replay.cli.main import main; from flight_replay.output.charts import plot\n"
        "def fail(*_): raise ValueError('\\x1b[31m')\n"
        "plot.save_plot = fail; sys.exit(main())"
    )
    options = ["--tlog", str(log), "--plot", "a.png", *DRY, *(["-v"] if verbose else [])]
    done = subprocess.run([sys.executable, "-c", code, *options], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert ("ERROR:flight_replay.cli.output_step:cannot write a.png\nTraceback" in done.stderr) is verbose
    assert ("Traceback" in done.stderr) is verbose
    assert "\x1b" not in done.stderr


@pytest.mark.skipif(os.name == "nt", reason="names are text there")
def test_a_log_whose_name_is_no_text_has_results_and_a_report(
    log: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A byte that is no UTF-8 is shown as an escape."""
    named = log.rename(os.fsdecode(b"\xff.tlog"))
    assert main(["--tlog", str(named), "--report", "a.html", *DRY]) == 0
    assert json.loads(capsys.readouterr().out)["log"]["path"].endswith(".tlog")
    assert "\\udcff.tlog" in Path("a.html").read_text(encoding="utf-8")
