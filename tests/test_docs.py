"""The documentation agrees with the program, and its links lead somewhere."""

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from flight_replay.cli.main import main
from flight_replay.cli.options import build_parser
from tests.helpers.paths import ROOT

PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)


def anchors(page: Path) -> set[str]:
    """The names by which a page's headings are linked, as GitHub and mkdocs make them."""
    headings = HEADING.findall(page.read_text(encoding="utf-8"))
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    """Every file that is linked is there, and every heading."""
    for link in LINK.findall(page.read_text(encoding="utf-8")):
        if re.match(r"[a-z]+:", link):
            continue
        place, _, anchor = link.partition("#")
        target = (page.parent / place).resolve() if place else page
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


def test_the_options_page_is_the_help(monkeypatch: pytest.MonkeyPatch) -> None:
    """--help and the page have the same words (Python versions break the usage line differently)."""
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setenv("NO_COLOR", "1")
    page = (ROOT / "docs" / "options.md").read_text(encoding="utf-8")
    found = re.search(r"<!-- help -->\s*```\w*\n(.*?)```", page, re.DOTALL)
    assert found
    shown = build_parser().format_help()
    assert found[1].split()[-200:] == shown.split()[-200:]
    assert set(shown.split()) == set(found[1].split())


def keys_of(value: object) -> Iterator[str]:
    """The names of all that a JSON value holds."""
    for part in value if isinstance(value, list) else ():
        yield from keys_of(part)
    if isinstance(value, dict):
        for key, part in value.items():
            yield key
            yield from keys_of(part)


def test_the_json_object_is_documented(capsys: pytest.CaptureFixture[str]) -> None:
    """Each key of a plan's object; reasons of what was rejected are words for people."""
    assert main([str(ROOT / "data" / "flight.tlog"), "--dry-run", "--json"]) == 0
    page = (ROOT / "docs" / "files.md").read_text(encoding="utf-8")
    section = page.partition("## The JSON object")[2]
    named = set(re.findall(r"\w+", section))
    assert [
        key for key in keys_of(json.loads(capsys.readouterr().out)) if " " not in key and key not in named
    ] == []


@pytest.mark.parametrize("name", ["follow", "many", "simulator", "upload"])
def test_benchmarks_say_what_they_do(name: str) -> None:
    """And end, without a run."""
    command = [sys.executable, str(ROOT / "benchmarks" / f"{name}.py"), "--help"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    assert "positional arguments" in done.stdout


def test_the_library_example_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On the built-in copter; it leaves its picture behind."""
    monkeypatch.delenv("SITL_BINARY", raising=False)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "data").symlink_to(ROOT / "data")
    page = (ROOT / "docs" / "library.md").read_text(encoding="utf-8")
    example = re.search(r"```python\n(.*?)```", page, re.DOTALL)
    assert example
    exec(compile(example[1], "library.md", "exec"), {})
    assert (tmp_path / "replay.png").is_file()
