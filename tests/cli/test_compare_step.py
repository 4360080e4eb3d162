"""compare_step.py: two logs, of which a part may be measured."""

import json
from pathlib import Path

import pytest

from flight_replay.cli.main import main
from tests.helpers.track_files import gpx, moving


@pytest.mark.parametrize(("options", "fixes"), [((), 47), (("--from", "40"), 8), (("--to", "30"), 30)])
def test_a_part_is_measured_as_the_whole(
    folder: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], fixes: int
) -> None:
    """However little of the replay it is."""
    (folder / "a.gpx").write_bytes(gpx(moving()))
    (folder / "b.gpx").write_bytes(gpx(moving(start_s=100.0)))
    assert main(["--compare", "a.gpx", "b.gpx", "--json", *options]) == 0
    compared = json.loads(capsys.readouterr().out)["compared"]
    assert compared["fixes"] == pytest.approx(fixes, abs=2)
    assert [compared["path_error_m"][way]["max"] for way in compared["path_error_m"]] == pytest.approx(
        [0.0, 0.0], abs=0.05
    )
    assert compared["position_error_m"]["max"] < 0.05
