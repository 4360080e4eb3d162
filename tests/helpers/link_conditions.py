"""What a test link does to the frames that pass over it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LinkConditions:
    """Shares of the frames in each direction, and seconds; ``jitter_s`` reorders frames."""

    loss: float = 0.0
    corrupt: float = 0.0
    duplicated: float = 0.0
    delay_s: float = 0.0
    jitter_s: float = 0.0
