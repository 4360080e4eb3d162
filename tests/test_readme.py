"""The README says what the program does."""

import re

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
    """--help and README agree word by word (pythons differ in how they break the usage line)."""
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setenv("NO_COLOR", "1")
    said = build_parser().format_help()
    assert block_after("<!-- help -->").split()[-200:] == said.split()[-200:]
    assert set(said.split()) == set(block_after("<!-- help -->").split())


@pytest.mark.parametrize("name", ["replay", "test"])
def test_readme_has_the_commands_that_ci_runs(name: str) -> None:
    """Each of the two commands works by itself: it installs first."""
    assert block_after(f"<!-- ci: {name} -->").startswith("pip install")


def test_readme_names_every_format() -> None:
    """Every suffix that can be written is in the table of files."""
    for suffix in (*SAVED_SUFFIXES, *SUFFIXES):
        assert f"`{suffix}`" in README


def test_options_in_the_readme_exist() -> None:
    """No option is told of that the program does not have."""
    known = set(build_parser()._option_string_actions)
    other_programs = {"--master", "--listen", "--home"}
    told = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", README))
    assert told <= known | other_programs
