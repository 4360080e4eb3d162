"""Standard output that is full, and file names that are too long: one line each, no traceback."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.helpers.paths import SAMPLE

FULL = Path("/dev/full")
needs_full = pytest.mark.skipif(not FULL.exists(), reason="this system has no /dev/full")

LINE = (
    "flight-replay: error: cannot write stdout: No space left on device; free some space, or write elsewhere"
)


def run(folder: Path, *arguments: str, output: Path = FULL, error: Path | None = None) -> tuple[int, str]:
    """Exit status and standard error of the program."""
    with output.open("w") as stdout, (error or folder / "stderr").open("w") as stderr:
        ended = subprocess.run(
            [sys.executable, "-m", "flight_replay", *arguments],
            cwd=folder,
            env=os.environ | {"PYTHONUNBUFFERED": ""},
            stdout=stdout,
            stderr=stderr,
            timeout=300,
            check=False,
        )
    return ended.returncode, "" if error else (folder / "stderr").read_text()


@needs_full
@pytest.mark.parametrize(
    "arguments",
    [["--help"], ["--version"], ["--print-completion", "bash"], ["--dry-run"], ["--dry-run", "--json"]],
    ids=["help", "version", "completion", "text", "JSON"],
)
def test_a_full_standard_output_is_one_line(tmp_path: Path, arguments: list[str]) -> None:
    """Exit status 1, and the reason of the system."""
    status, error = run(tmp_path, "--tlog", str(SAMPLE), *arguments)
    lines = [line for line in error.splitlines() if "error" in line or "Traceback" in line]
    assert status == 1
    assert lines == [LINE]


@needs_full
def test_a_full_standard_output_keeps_what_was_saved(tmp_path: Path) -> None:
    """The files are written all the same."""
    status, _ = run(
        tmp_path, "--tlog", str(SAMPLE), "--dry-run", "--save", "m.waypoints", "--report", "r.html"
    )
    assert status == 1
    assert (tmp_path / "m.waypoints").is_file()
    assert (tmp_path / "r.html").is_file()


@needs_full
def test_a_full_standard_error_keeps_the_exit_status(tmp_path: Path) -> None:
    """1 for a log that is not there."""
    status, _ = run(tmp_path, "--tlog", "none.tlog", output=tmp_path / "out", error=FULL)
    assert status == 1


@pytest.mark.parametrize(
    ("option", "suffix"),
    [("--save", ".plan"), ("--record", ".tlog"), ("--plot", ".svg"), ("--report", ".html")],
)
@pytest.mark.parametrize("letters", [245, 300])
def test_long_names_are_written_or_told(tmp_path: Path, option: str, suffix: str, letters: int) -> None:
    """245 letters and a suffix fit a file system; 300 do not, which is told before anything is read."""
    name = "a" * letters + suffix
    status, error = run(tmp_path, "--tlog", str(SAMPLE), "--dry-run", option, name, output=tmp_path / "out")
    if letters == 245:
        assert (status, error) == (0, "")
        assert option == "--record" or (tmp_path / name).is_file()
    else:
        assert (status, error.count("\n")) == (1, 1)
        assert "File name too long" in error
