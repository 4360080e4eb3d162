"""atomic.py: files are either whole or untouched."""

from pathlib import Path

import pytest

from flight_replay import atomic_write
from flight_replay.errors import FlightReplayError


def test_text_and_bytes_are_written_whole_and_leave_nothing_beside_them(tmp_path: Path) -> None:
    """Text goes out as UTF-8, bytes as they are, and no temporary file stays."""
    atomic_write.write(tmp_path / "a", "grün")
    atomic_write.write(str(tmp_path / "b"), b"\x00")
    assert (tmp_path / "a").read_bytes() == "grün".encode()
    assert (tmp_path / "b").read_bytes() == b"\x00"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b"]


def test_a_file_already_there_is_replaced_and_a_link_followed(tmp_path: Path) -> None:
    """The link stays a link; what it points to gets the new content."""
    target, link = tmp_path / "target", tmp_path / "link"
    target.write_text("old")
    link.symlink_to(target)
    atomic_write.write(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"


def test_a_place_that_cannot_be_written_is_one_clear_sentence(tmp_path: Path) -> None:
    """The error names the file and the cause, and the next step."""
    with pytest.raises(FlightReplayError, match=r"cannot write .*missing.*No such file.*; name a file"):
        atomic_write.write(tmp_path / "missing" / "file", "text")
    (tmp_path / "folder").mkdir()
    with pytest.raises(FlightReplayError, match="cannot write"):
        atomic_write.write(tmp_path / "folder", "text")
    assert [path.name for path in tmp_path.iterdir()] == ["folder"]
