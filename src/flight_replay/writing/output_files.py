"""Output files: checked before the flight, written beside their place, and put there whole or not at all."""

from __future__ import annotations

import errno
import os
import secrets
import stat
from collections.abc import Sequence
from contextlib import suppress
from itertools import chain, count
from pathlib import Path

from flight_replay.exceptions import FlightReplayError

_CREATE = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)

_ADVICE = {
    errno.EISDIR: "choose another name",
    errno.ENAMETOOLONG: "choose another name",
    errno.ENOSPC: "free some space, or choose another folder",
}


def check_suffix(path: Path | str, suffixes: Sequence[str]) -> str:
    """The suffix of ``path`` in lower case, such as ".plan".

    Raises:
        FlightReplayError: It is not one of ``suffixes``.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in suffixes:
        found = f'unknown suffix "{suffix}"' if suffix else "no suffix"
        raise FlightReplayError(f"{path}: {found}; use one of {', '.join(suffixes)}")
    return suffix


def check_place(path: Path | str, *, pipes: bool = False) -> None:
    """Refuse a place that a file cannot be written to; a file is made beside it, and removed again.

    Args:
        path: the place.
        pipes: whether what is there may be no regular file, such as a named pipe; it is then not tried.

    Raises:
        FlightReplayError: It is a folder, or in one that does not exist or takes no file, or no regular file.
    """
    target = Path(path).expanduser()
    if not target.parent.is_dir():
        raise FlightReplayError(f"cannot write {path}: no folder {Path(path).parent}; create it first")
    try:
        target.lstat()
    except FileNotFoundError:
        pass
    except OSError as error:
        raise FlightReplayError(f"cannot write {path}: {error.strerror}; choose another name") from error
    if target.is_dir():
        raise cannot_write(path, IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR)))
    if not (pipes and _is_special(target)):
        NewFile(path).discard()


def _is_special(target: Path) -> bool:
    """Whether it is neither file nor folder, but a pipe, a socket or a device; through links, too."""
    try:
        mode = target.stat().st_mode
    except OSError:
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


def write_atomically(path: Path | str, content: bytes | str) -> None:
    """Write ``content`` to ``path``, replacing a file that is there; follows a link.

    Text is written as UTF-8, with escapes for what that cannot express: the name of a log may hold any bytes.

    Raises:
        FlightReplayError: The folder does not exist, is full or not writable, or a pipe or device is there.
    """
    new = NewFile(path)
    try:
        new.file.write(content.encode(errors="backslashreplace") if isinstance(content, str) else content)
        new.put_in_place()
    except OSError as error:
        new.discard()
        raise cannot_write(path, error) from error


def unused_path(path: Path) -> Path:
    """The path, or a numbered one: two programs may write to one folder in the same second."""
    numbered = (path.with_stem(f"{path.stem}-{number}") for number in count(2))
    return next(other for other in chain([path], numbered) if not other.exists())


class NewFile:
    """A file that becomes ``path`` once it is complete.

    Until then it has another name in the same folder, which cannot be guessed: who may write to that
    folder cannot put a link there. It gets the permissions of the file that it replaces.
    """

    def __init__(self, path: Path | str, *, hidden: bool = True) -> None:
        """Create it.

        Args:
            path: what it becomes.
            hidden: whether it is of no use to anybody before.

        Raises:
            FlightReplayError: The folder does not exist or is not writable, or a pipe or device is there.
        """
        target = Path(path).expanduser()
        self._target = Path(os.path.realpath(target)) if target.is_symlink() else target
        if _is_special(self._target):
            raise FlightReplayError(f"{path} is not a regular file; choose another name")
        unique = secrets.token_hex(8)
        shown = f"{self._target.stem}.unfinished-{unique}{self._target.suffix}"
        # Where it is until then.
        self.path = self._target.with_name(f".flight-replay.{unique}.part" if hidden else shown)
        try:
            number = os.open(self.path, _CREATE, 0o666)
        except OSError as error:
            raise cannot_write(path, error) from error
        self.file = open(number, "wb")  # noqa: SIM115, PTH123 - closed by put_in_place or discard

    def put_in_place(self) -> None:
        """Close it and give it its name.

        Raises:
            OSError: It cannot be written or renamed.
        """
        self.file.close()
        with suppress(FileNotFoundError):
            self.path.chmod(stat.S_IMODE(self._target.stat().st_mode))
        self.path.replace(self._target)

    def discard(self) -> None:
        """Remove it."""
        with suppress(OSError):
            self.file.close()
        self.path.unlink(missing_ok=True)


def cannot_write(path: Path | str, error: OSError) -> FlightReplayError:
    """What kept a file from being written, and what to do."""
    advice = _ADVICE.get(error.errno or 0, "choose another folder")
    return FlightReplayError(f"cannot write {path}: {error.strerror or error}; {advice}")
