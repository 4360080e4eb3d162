"""examples/: each example runs and prints its results."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from flight_replay.logs.sample import sample_log
from flight_replay.mission import formats
from tests.helpers.paths import EXAMPLES


def run(name: str, folder: Path, *arguments: str) -> str:
    """What an example prints; warnings are errors."""
    command = [sys.executable, "-W", "error", str(EXAMPLES / name), *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_plan_only_saves_a_mission(tmp_path: Path) -> None:
    """The sample flight becomes 100 waypoints 20 m above home in a file that loads."""
    assert "100 waypoints" in run("plan_only.py", tmp_path)
    mission = formats.load_mission(tmp_path / "mission.waypoints")
    assert len(mission.waypoints) == 100
    assert {item.alt_m for _, item in mission.waypoints} == {20.0}


def test_replay_builtin_flies(tmp_path: Path) -> None:
    """Half a minute of the mission is flown with a path error below a metre."""
    output = run("replay_builtin.py", tmp_path)
    assert "waypoint 5 at" in output
    assert "ended by: duration" in output
    for way in ("recorded to flown", "flown to recorded"):
        found = re.search(rf"path error, {way}: mean ([\d.]+) m", output)
        assert found is not None
        assert float(found[1]) < 1


def test_draw_measures_draws(tmp_path: Path) -> None:
    """A picture of the size that docs shows."""
    pytest.importorskip("matplotlib")
    assert "wrote measures.png" in run("draw_measures.py", tmp_path)
    assert (tmp_path / "measures.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_draw_following_draws(tmp_path: Path) -> None:
    """A picture of the size that docs shows."""
    pytest.importorskip("matplotlib")
    assert "wrote following.png" in run("draw_following.py", tmp_path)
    assert (tmp_path / "following.png").read_bytes().startswith(b"\x89PNG")


def test_compare_flights_measures_half_a_metre(tmp_path: Path) -> None:
    """The sample flight, moved by half a metre, has a mean position error of half a metre."""
    output = run("compare_flights.py", tmp_path)
    assert re.search(r"position error: mean 0\.50 m", output)
    again = run("compare_flights.py", tmp_path, str(sample_log()), str(sample_log()))
    assert "path error, first to second: mean 0.00 m" in again
    assert "position error: mean 0.00 m, p95 0.00 m, max 0.00 m" in again


@pytest.mark.parametrize(
    ("command", "told"),
    [
        ("compare_flights.py none none", "none does not exist; name a recorded flight"),
        ("compare_flights.py none", "usage: python examples/compare_flights.py [FIRST SECOND]"),
        ("fit_budgets.py none", "none does not exist; name a recorded flight"),
        ("plan_only.py none", "none does not exist; name a recorded flight"),
        ("replay_builtin.py none", "none does not exist; name a recorded flight"),
        (
            "simulate_mission.py none.plan",
            "cannot read none.plan: No such file or directory; give a mission file",
        ),
        (
            "two_firmwares.py none none none",
            "usage: python examples/two_firmwares.py OLD_SITL NEW_SITL PATH...",
        ),
    ],
)
def test_what_an_example_cannot_use_is_one_line(command: str, told: str, tmp_path: Path) -> None:
    """As on the command line, no traceback."""
    name, *arguments = command.split()
    script = [sys.executable, str(EXAMPLES / name), *arguments]
    done = subprocess.run(script, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (1, told + "\n")


@pytest.mark.slow
@pytest.mark.realtime
@pytest.mark.sitl
def test_a_firmware_flies_as_it_did(tmp_path: Path) -> None:
    """A binary compared with itself: two tables, and nothing that became worse beyond chance."""
    pytest.importorskip("distributed")
    sitl = os.environ.get("SITL_BINARY") or pytest.skip("SITL_BINARY names no ArduCopter")
    (tmp_path / "short.tlog").write_bytes(sample_log().read_bytes()[:500_000])
    output = run("two_firmwares.py", tmp_path, sitl, sitl, "short.tlog")
    assert "1 flights: 0 became worse" in output
    assert {"old.parquet", "new.parquet"} <= {path.name for path in tmp_path.iterdir()}
