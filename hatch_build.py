"""Builds wheels with compiled parts: the flight model, what a fit computes number by number, log searches.

The flight model is four to seven times as fast then, a fit up to fourteen, and flies the same to the last
bit. All stays plain Python where there is no C compiler, or no Python.h, and in editable installs; so does
reading telemetry logs, in numpy.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

_ROOMS = (
    "geometry/scalar",
    "planning/fit/scalar",
    "simulator/dynamics",
    "simulator/navigation",
    "simulator/flight",
)
_NOT_COMPILED = frozenset({"__init__.py", "spline_end.py", "trajectory.py", "guided_trajectory.py"})
"""What works with numpy's arrays gains nothing."""
_CORE = "flight_replay/logs/tlog/core/_frame_core"
_C_FLAGS = "-ffp-contract=off -fno-semantic-interposition"
"""Multiplications and additions in one, which some processors have, would change the last bits. Functions
that another library may replace are called in a roundabout way, which takes the model a tenth longer."""
_LONGEST_S = 600
_CORE_SETUP = """
from setuptools import Extension, setup
flags = ["-std=c11", "-O3"]
setup(ext_modules=[Extension({module!r}, [{path!r}], extra_compile_args=flags)])
"""
# With -O3 -g1 a C compiler takes half as long again, and what it makes is five times as large and no faster.
_SETUP = """
import os
from mypyc.build import mypycify
from setuptools import setup
flags = ["--python-version=3.10", "--follow-imports=silent", "--ignore-missing-imports"]
flags += ["--cache-dir", os.devnull]
options = {{"opt_level": "2", "debug_level": "0", "group_name": "flight_replay", "target_dir": {target!r}}}
setup(ext_modules=mypycify(flags + {modules!r}, **options))
"""


class FlightModelHook(BuildHookInterface[Any]):
    """Puts compiled modules into a wheel, beside their sources."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, and say so if that fails."""
        if version == "editable":
            return
        self._scratch = Path(tempfile.mkdtemp())
        source = Path(self.root, "src")
        scratch = str(self._scratch / "c")
        self._add("The flight model", _SETUP.format(modules=flight_model(source), target=scratch), build_data)
        if os.name != "nt":  # where a library without Python in it takes other tools
            core = _CORE_SETUP.format(module=_CORE.replace("/", "."), path=f"{_CORE}.c")
            self._add("The reader of telemetry logs", core, build_data)

    def _add(self, name: str, setup: str, build_data: dict[str, Any]) -> None:
        """Compile a part, or say why it stays plain."""
        try:
            libraries = compiled(setup, Path(self.root, "src"), Path(tempfile.mkdtemp(dir=self._scratch)))
        except subprocess.CalledProcessError as error:
            self._stay_plain(name, error.stderr.strip().rpartition("\n")[2])
        except (OSError, subprocess.TimeoutExpired) as error:
            self._stay_plain(name, str(error))
        else:
            build_data["force_include"].update(libraries)
            build_data["infer_tag"], build_data["pure_python"] = True, False

    def _stay_plain(self, name: str, reason: str) -> None:
        self.app.display_warning(f"{name} is not compiled, and slower: {reason}")

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove what the compiler left."""
        if version != "editable":
            shutil.rmtree(self._scratch, ignore_errors=True)


def flight_model(source: Path) -> list[str]:
    """The modules that are compiled, as paths below ``source``."""
    found = (each for room in _ROOMS for each in (source / "flight_replay" / room).glob("*.py"))
    return sorted(each.relative_to(source).as_posix() for each in found if each.name not in _NOT_COMPILED)


def compiled(setup: str, source: Path, scratch: Path) -> dict[str, str]:
    """The libraries that a setup script compiles, and where each belongs.

    Raises:
        OSError, subprocess.SubprocessError: they cannot be compiled, or not in time.
    """
    libraries = scratch / "libraries"
    arguments = ["build_ext", "--build-lib", str(libraries), "--build-temp", str(scratch / "objects")]
    flags = {} if os.name == "nt" else {"CFLAGS": f"{os.environ.get('CFLAGS', '')} {_C_FLAGS}"}
    subprocess.run(
        [sys.executable, "-c", setup, *arguments],
        cwd=source, env={**os.environ, **flags}, timeout=_LONGEST_S,
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    return {
        str(each): each.relative_to(libraries).as_posix() for each in libraries.rglob("*") if each.is_file()
    }
