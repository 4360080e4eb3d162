"""output_files.py: suffixes are checked, and files are written whole or not at all."""

import os
import stat
from pathlib import Path

import pytest

from flight_replay.exceptions import FlightReplayError
from flight_replay.writing.output_files import NewFile, check_place, check_suffix, write_atomically


def test_a_known_suffix_is_returned_in_lower_case() -> None:
    """Suffixes are compared without regard to case."""
    assert check_suffix("Mission.PLAN", (".plan", ".kml")) == ".plan"


@pytest.mark.parametrize(
    ("name", "reason"), [("mission.doc", r'unknown suffix "\.doc"'), ("mission", "no suffix")]
)
def test_an_unknown_suffix_is_refused(name: str, reason: str) -> None:
    """The error names the file, the reason and every suffix that would do."""
    with pytest.raises(FlightReplayError, match=rf"^{name}: {reason}; use one of \.plan, \.kml$"):
        check_suffix(name, (".plan", ".kml"))


def test_text_and_bytes_are_written_and_no_temporary_file_stays(tmp_path: Path) -> None:
    """Text is written as UTF-8, bytes as they are."""
    write_atomically(tmp_path / "a", "grün")
    write_atomically(str(tmp_path / "b"), b"\x00")
    assert (tmp_path / "a").read_bytes() == "grün".encode()
    assert (tmp_path / "b").read_bytes() == b"\x00"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b"]


def test_a_file_already_there_is_replaced_and_a_link_followed(tmp_path: Path) -> None:
    """The link stays a link; its target gets the new content."""
    target, link = tmp_path / "target", tmp_path / "link"
    target.write_text("old")
    link.symlink_to(target)
    write_atomically(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"


def test_a_file_that_cannot_be_written_is_one_error(tmp_path: Path) -> None:
    """The error names the file, the reason and the next step; nothing is left behind."""
    with pytest.raises(FlightReplayError, match=r"cannot write .*missing.*No such file.*; choose another"):
        write_atomically(tmp_path / "missing" / "file", "text")
    (tmp_path / "folder").mkdir()
    with pytest.raises(FlightReplayError, match="Is a directory; choose another name"):
        write_atomically(tmp_path / "folder", "text")
    assert [path.name for path in tmp_path.iterdir()] == ["folder"]


def test_a_place_is_tried_before_it_is_needed(tmp_path: Path) -> None:
    """What a file can be written to is left as it was; a folder, and one that takes no file, are refused."""
    (tmp_path / "there").write_text("kept")
    for name in ("there", "new"):
        check_place(tmp_path / name)
    assert (tmp_path / "there").read_text() == "kept"
    assert [path.name for path in tmp_path.iterdir()] == ["there"]
    with pytest.raises(FlightReplayError, match=r"no folder .*missing; create it first"):
        check_place(tmp_path / "missing" / "file")
    with pytest.raises(FlightReplayError, match="Is a directory; choose another name"):
        check_place(tmp_path)
    if Path("/proc").is_dir():
        with pytest.raises(FlightReplayError, match=r"/proc/file: .*; choose another folder"):
            check_place("/proc/file")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
@pytest.mark.parametrize("linked", [False, True], ids=["itself", "linked"])
def test_a_pipe_is_not_replaced(tmp_path: Path, linked: bool) -> None:
    """Nor is it tried where one may be: it is written to directly, and would wait for its reader."""
    os.mkfifo(tmp_path / "pipe")
    named = tmp_path / ("link" if linked else "pipe")
    if linked:
        named.symlink_to(tmp_path / "pipe")
    check_place(named, pipes=True)
    for write in (check_place, NewFile, lambda path: write_atomically(path, "text")):
        with pytest.raises(
            FlightReplayError, match=f"{named.name} is not a regular file; choose another name"
        ):
            write(named)
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)
    assert {path.name for path in tmp_path.iterdir()} == {"pipe", named.name}


def test_permissions_of_a_replaced_file_are_kept(tmp_path: Path) -> None:
    """A new file gets those of any new file here."""
    (tmp_path / "private").write_text("old")
    (tmp_path / "private").chmod(0o600)
    (tmp_path / "usual").touch()
    write_atomically(tmp_path / "private", "new")
    write_atomically(tmp_path / "fresh", "new")
    modes = {path.name: path.stat().st_mode for path in tmp_path.iterdir()}
    assert modes["private"] & 0o777 == 0o600
    assert modes["fresh"] == modes["usual"]


def test_names_on_the_way_cannot_be_guessed(tmp_path: Path) -> None:
    """Two files on the way to the same place have different names."""
    names = []
    for _ in range(2):
        new = NewFile(tmp_path / "file")
        names += [path.name for path in tmp_path.iterdir()]
        new.discard()
    assert len(set(names)) == 2


@pytest.mark.parametrize("link", ["symbolic", "hard"])
def test_a_link_in_the_way_is_not_written_through(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, link: str
) -> None:
    """Even if somebody guessed the name."""
    monkeypatch.setattr("secrets.token_hex", lambda _: "known")
    victim, guessed = tmp_path / "victim", tmp_path / ".flight-replay.known.part"
    victim.write_text("kept")
    (guessed.symlink_to if link == "symbolic" else guessed.hardlink_to)(victim)
    with pytest.raises(FlightReplayError, match="cannot write"):
        write_atomically(tmp_path / "file", "text")
    assert victim.read_text() == "kept"


@pytest.mark.parametrize("name", ["a" * 245, "\u30c9" * 82], ids=["ASCII", "Japanese"])
def test_a_name_as_long_as_the_file_system_allows_is_written(tmp_path: Path, name: str) -> None:
    """The name on the way is not made of it: 255 bytes hold 82 Japanese letters."""
    write_atomically(tmp_path / name, "text")
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_text_that_is_no_unicode_is_escaped(tmp_path: Path) -> None:
    """The name of a log may hold any bytes, and come into a report."""
    write_atomically(tmp_path / "file", "a\udcff")
    assert (tmp_path / "file").read_text() == "a\\udcff"
