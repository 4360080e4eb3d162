"""README.md agrees with the program."""

import re
from pathlib import Path

import pytest

from flight_replay.cli.options import build_parser
from flight_replay.mission.formats import SAVED_SUFFIXES
from flight_replay.output.charts.plot import SUFFIXES
from tests.helpers.paths import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")


def block_after(mark: str) -> str:
    """The text of the code block behind a mark."""
    found = re.search(re.escape(mark) + r"\s*```\w*\n(.*?)```", README, re.DOTALL)
    assert found, f"README.md has no block after {mark}"
    return found[1]


def test_readme_shows_the_help(monkeypatch: pytest.MonkeyPatch) -> None:
    """--help and README have the same words (Python versions break the usage line differently)."""
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setenv("NO_COLOR", "1")
    shown = build_parser().format_help()
    assert block_after("<!-- help -->").split()[-200:] == shown.split()[-200:]
    assert set(shown.split()) == set(block_after("<!-- help -->").split())


@pytest.mark.parametrize("name", ["replay", "test"])
def test_readme_has_the_commands_that_ci_runs(name: str) -> None:
    """Each of the two commands installs the package first."""
    assert block_after(f"<!-- ci: {name} -->").startswith("pip install")


def test_readme_names_every_format() -> None:
    """Every suffix of an output file is in the table of files."""
    for suffix in (*SAVED_SUFFIXES, *SUFFIXES):
        assert f"`{suffix}`" in README


def test_options_in_the_readme_exist() -> None:
    """Every option in the README is one of the program."""
    known = set(build_parser()._option_string_actions)
    other_programs = {"--master", "--listen", "--home", "--fly"}
    shown = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", README))
    assert shown <= known | other_programs


def test_the_library_example_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It prints what it says, and leaves the mission behind."""
    monkeypatch.chdir(tmp_path)
    example = re.search(r"```python\n(.*?)```", README, re.DOTALL)
    assert example
    exec(compile(example[1], "README.md", "exec"), {})
    assert (tmp_path / "mission.plan").is_file()
