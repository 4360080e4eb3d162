"""Fly a recorded drone flight again, on a simulator or a real vehicle, and measure how close it came.

What programs and notebooks need is here; docs/library.md shows it in use. It is imported when it is
first asked for, because the command line needs little of it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flight_replay.library import errors, figure, fit, plan, replay
    from flight_replay.logs.read_log import read_log

    __version__: str

__all__ = ["__version__", "errors", "figure", "fit", "plan", "read_log", "replay"]


def __getattr__(name: str) -> Any:
    """What is in ``__all__``, imported now."""
    if name == "__version__":
        from importlib.metadata import version

        return version("flight-replay")
    if name == "read_log":
        from flight_replay.logs.read_log import read_log

        return read_log
    if name in __all__:
        from flight_replay import library

        return getattr(library, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
