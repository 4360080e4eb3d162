"""The order of the source tree: sizes, names and imports, which no other check holds."""

from __future__ import annotations

import ast
import re
import subprocess
from collections import defaultdict
from collections.abc import Iterable, Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from tests.helpers.paths import ROOT

SOURCE = ROOT / "src"
PACKAGE = SOURCE / "flight_replay"
FILES = sorted(PACKAGE.rglob("*.py"))
MAX_FILES, MAX_TOP_FOLDERS, MAX_TOP_FILES = 20, 10, 8
MAX_FUNCTION_LINES = 40
MACHINE_PATH = re.compile(rb"(?<![\w.~-])/(?:work|root|home/[a-z]\w*|Users/\w+)/")
"""The start of a path that only one machine has; a user's home in an example is one too."""


def dotted(path: Path) -> str:
    """The name that a source file is imported by."""
    return ".".join(path.relative_to(SOURCE).with_suffix("").parts).removesuffix(".__init__")


MODULES = {dotted(path): path for path in FILES}


@cache
def tree_of(path: Path) -> ast.Module:
    """A source file as a syntax tree."""
    return ast.parse(path.read_bytes())


def imported_by(tree: ast.Module) -> Iterator[str]:
    """The modules of the package that a module imports anywhere, for types alone as well."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            members = [f"{node.module}.{alias.name}" for alias in node.names]
            names = [name if name in MODULES else node.module for name in members]
        else:
            continue
        yield from (name for name in names if name in MODULES)


def named_twice(named: Iterable[tuple[str, Path]]) -> dict[str, list[str]]:
    """The names that stand for more than one thing, and the files they stand in."""
    places: dict[str, list[str]] = defaultdict(list)
    for name, path in named:
        places[name].append(path.relative_to(PACKAGE).as_posix())
    return {name: files for name, files in places.items() if len(files) > 1}


def test_folders_are_small() -> None:
    """No folder of the package has more than twenty files."""
    counts = {
        folder.relative_to(SOURCE).as_posix(): sum(path.parent == folder for path in FILES)
        for folder in {path.parent for path in FILES}
    }
    assert {folder: count for folder, count in counts.items() if count > MAX_FILES} == {}


def test_the_top_of_the_package_is_small() -> None:
    """A newcomer sees at most ten folders and eight files."""
    folders = {path.relative_to(PACKAGE).parts[0] for path in FILES if path.parent != PACKAGE}
    assert len(folders) <= MAX_TOP_FOLDERS
    assert sum(path.parent == PACKAGE for path in FILES) <= MAX_TOP_FILES


def test_a_public_class_name_means_one_class() -> None:
    """No two modules define public classes of one name."""
    classes = (
        (node.name, path)
        for path in FILES
        for node in tree_of(path).body
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    )
    assert named_twice(classes) == {}


def test_a_module_name_means_one_module() -> None:
    """No two files have one name, except the vehicle's and the simulator's side of one protocol."""
    modules = ((path.stem, path) for path in FILES if path.stem != "__init__")
    twice = {
        name: files
        for name, files in named_twice(modules).items()
        if sorted(file.split("/")[0] for file in files) != ["simulator", "vehicle"]
    }
    assert twice == {}


def test_no_imports_go_in_a_circle() -> None:
    """The files can be read in an order in which each needs only those before it."""
    needs = {name: set(imported_by(tree_of(path))) - {name} for name, path in MODULES.items()}
    try:
        TopologicalSorter(needs).prepare()
    except CycleError as error:
        pytest.fail(" <- ".join(error.args[1]))


def test_functions_fit_a_screen() -> None:
    """No function is longer than forty lines."""
    long = {
        f"{name}.{node.name}": lines
        for name, path in MODULES.items()
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and (lines := (node.end_lineno or node.lineno) - node.lineno + 1) > MAX_FUNCTION_LINES
    }
    assert long == {}


def test_no_file_names_a_place_on_one_machine() -> None:
    """No tracked file but the history holds an absolute path of somebody's machine."""
    if not (ROOT / ".git").exists():
        pytest.skip("not a clone")
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True).stdout
    names = {name for name in listed.decode().split("\0") if name} - {"CHANGELOG.md"}
    files = [ROOT / name for name in names if (ROOT / name).is_file()]
    found = {
        str(path.relative_to(ROOT)): match[0]
        for path in files
        if (match := MACHINE_PATH.search(path.read_bytes()))
    }
    assert found == {}
