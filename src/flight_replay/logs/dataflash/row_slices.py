"""Works through long columns some rows at a time: the working memory stays small."""

from __future__ import annotations

from collections.abc import Iterator

_ROWS_AT_ONCE = 1 << 16


def slices(n: int) -> Iterator[slice]:
    """All of n rows, some at a time."""
    return (slice(first, min(first + _ROWS_AT_ONCE, n)) for first in range(0, n, _ROWS_AT_ONCE))
