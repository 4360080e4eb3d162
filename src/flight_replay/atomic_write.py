"""Files that are either whole or untouched: written beside their place, then put there in one step."""

from __future__ import annotations

import os
from pathlib import Path

from flight_replay.errors import FlightReplayError


def write(path: Path | str, content: bytes | str) -> None:
    """Put ``content`` (text as UTF-8) at ``path``; a file already there is replaced, a link followed.

    Raises:
        FlightReplayError: The folder is missing, full or not to be written to.
    """
    place = Path(path).expanduser()
    place = place.resolve() if place.is_symlink() else place
    part = place.with_name(f".{place.name}.{os.getpid()}.part")
    try:
        part.write_bytes(content.encode() if isinstance(content, str) else content)
        part.replace(place)
    except OSError as error:
        part.unlink(missing_ok=True)
        why = error.strerror or error
        raise FlightReplayError(
            f"cannot write {path}: {why}; name a file in a folder you may write to"
        ) from error
