"""The compiled core of the reader finds what numpy finds, where there is a compiler to compile it with."""

from __future__ import annotations

import io
import shutil
import subprocess
from dataclasses import fields
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flight_replay.logs.byte_source import OpenLog
from flight_replay.logs.tlog.byte_rows import rows_at
from flight_replay.logs.tlog.columns import Records
from flight_replay.logs.tlog.core import frame_core
from flight_replay.logs.tlog.core.frame_core import FrameCore
from flight_replay.logs.tlog.frame_search import FrameSearch
from flight_replay.logs.tlog.frames import HEADER_LENGTH, frame_lengths
from flight_replay.logs.tlog.nested_frames import LOOK_BACK, possible_enclosures
from flight_replay.logs.tlog.scan import scan
from tests.helpers.mutations import MUTATIONS, mutated
from tests.helpers.paths import SAMPLE
from tests.logs.tlog.test_mutated import originals

SOURCE = Path(frame_core.__file__).parent / "_frame_core.c"
LIKELY = st.lists(st.sampled_from([0xFD, 0xFE, 0, 24, 33, 9, 28, 30, 1, 255]), max_size=3000).map(bytes)
"""Bytes that look like headers everywhere."""


@pytest.fixture(scope="module")
def core(tmp_path_factory: pytest.TempPathFactory) -> FrameCore:
    """The core, compiled for the tests alone."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler")
    folder = tmp_path_factory.mktemp("core")
    library = folder / f"_frame_core{EXTENSION_SUFFIXES[0]}"
    flags = ["-std=c11", "-O3", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]
    subprocess.run([compiler, *flags, str(SOURCE), "-o", str(library)], check=True)
    loaded = frame_core.load(folder)
    assert loaded is not None
    return loaded


def read(data: bytes, block_length: int, core: FrameCore | None) -> tuple[Records, int]:
    """What is read with the core, or without."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(frame_core, "CORE", core)
        return scan(OpenLog("made", io.BytesIO(data)), None, block_length)


def assert_read_alike(data: bytes, block_length: int, core: FrameCore) -> None:
    """Hold all columns of all records against those of numpy."""
    (plain, length), (compiled, its_length) = (read(data, block_length, each) for each in (None, core))
    assert (plain.empty, length) == (compiled.empty, its_length)
    for message in ("positions", "heartbeats", "gps", "gps2", "reports"):
        one, other = getattr(plain, message), getattr(compiled, message)
        for column in fields(one):
            assert np.array_equal(getattr(one, column.name), getattr(other, column.name)), column.name


def test_the_sample_is_read_alike(core: FrameCore) -> None:
    assert_read_alike(SAMPLE.read_bytes(), 1 << 20, core)


def test_damaged_logs_are_read_alike(core: FrameCore) -> None:
    logs = originals()
    for seed in range(200):
        chance = np.random.default_rng(seed)
        data = mutated(logs, chance, MUTATIONS)
        assert_read_alike(data, int(chance.choice([300, 1_000, 1 << 20])), core)


@given(LIKELY, st.sampled_from([(33, 0, 24), (253, 77), (33,)]), st.integers(0, 100))
def test_the_same_headers_are_found(
    core: FrameCore, made: bytes, messages: tuple[int, ...], start: int
) -> None:
    data = np.frombuffer(made + bytes(HEADER_LENGTH + start), np.uint8).copy()
    search, stop = FrameSearch(messages), len(data) - HEADER_LENGTH
    found = []
    for each in (None, core):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(frame_core, "CORE", each)
            found.append([starts.tolist() for starts in search.find(data, start, stop)])
    assert found[0] == found[1]


@given(LIKELY)
def test_the_same_enclosures_are_found(core: FrameCore, made: bytes) -> None:
    """But for what is no frame by all of its header, or not around the place: either may leave that in."""
    data = np.frombuffer(bytes(LOOK_BACK) + made + bytes(HEADER_LENGTH), np.uint8).copy()
    places = np.arange(LOOK_BACK, len(data) - HEADER_LENGTH, 7)
    found = []
    for each in (None, core):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(frame_core, "CORE", each)
            pairs = possible_enclosures(data, places)
        stop = pairs.start + frame_lengths(rows_at(data, pairs.start, HEADER_LENGTH))
        around = (pairs.start < pairs.place) & (stop > pairs.place)
        found.append((pairs.start[around].tolist(), pairs.place[around].tolist()))
    assert found[0] == found[1]


def test_nothing_outside_of_the_bytes_is_looked_at(core: FrameCore) -> None:
    data = np.zeros(100, np.uint8)
    table = np.zeros(1 << 16, np.uint8)
    with pytest.raises(IndexError):
        core.headers(data, (0, 95), (33,), table, table)
    with pytest.raises(IndexError):
        core.are_valid(data, np.array([100]))
    with pytest.raises(IndexError):
        core.enclosures(data, np.array([50]), table[:LOOK_BACK], table[:LOOK_BACK])
    assert not core.are_valid(np.full(3, 0xFD, np.uint8), np.arange(3)).any()


def test_without_a_library_there_is_no_core(tmp_path: Path) -> None:
    assert frame_core.load(tmp_path) is None
    (tmp_path / f"_frame_core{EXTENSION_SUFFIXES[0]}").write_bytes(b"no library")
    assert frame_core.load(tmp_path) is None
