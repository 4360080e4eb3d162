"""README.md agrees with the program."""

import re

import pytest

from flight_replay.cli.many.many_options import build_many_parser
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


@pytest.mark.parametrize("name", ["replay", "test"])
def test_readme_has_the_commands_that_ci_runs(name: str) -> None:
    """Each of the two commands installs the package first."""
    assert block_after(f"<!-- ci: {name} -->").startswith("pip install")


def test_the_docs_name_every_format() -> None:
    """Every suffix of an output file is in the table of files."""
    files = (ROOT / "docs" / "files.md").read_text(encoding="utf-8")
    for suffix in (*SAVED_SUFFIXES, *SUFFIXES):
        assert f"`{suffix}`" in files


def test_options_in_the_readme_exist() -> None:
    """Every option in the README is one of the program."""
    known = {*build_parser()._option_string_actions, *build_many_parser()._option_string_actions}
    other_programs = {"--master", "--listen", "--home", "--fly"}
    shown = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", README))
    assert shown <= known | other_programs


def test_the_readme_can_be_read_at_a_sitting() -> None:
    """What is more than that is in docs/."""
    assert len(README.splitlines()) < 150
