"""Output files: their suffixes are checked before the flight, and they are written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from flight_replay.errors import FlightReplayError


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


def write_atomically(path: Path | str, content: bytes | str) -> None:
    """Write ``content`` (text as UTF-8) to ``path``, replacing a file that is there; follows a link.

    Raises:
        FlightReplayError: The folder does not exist, is full or is not writable.
    """
    target = Path(path).expanduser()
    target = target.resolve() if target.is_symlink() else target
    temporary = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        temporary.write_bytes(content.encode() if isinstance(content, str) else content)
        temporary.replace(target)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        reason = error.strerror or error
        raise FlightReplayError(f"cannot write {path}: {reason}; choose another folder") from error
