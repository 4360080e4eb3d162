"""Numbers of things in messages."""

from __future__ import annotations


def counted(count: int, noun: str) -> str:
    """A number of things, such as "1 fix" or "2 fixes"; ``noun`` is for one of them."""
    return f"1 {noun}" if count == 1 else f"{count} {_plural(noun)}"


def counted_of(part: int, whole: int, noun: str) -> str:
    """Some of a number of things, such as "2 of 3 fixes", "all 3 fixes" or "the only fix"."""
    if part == whole == 1:
        return f"the only {noun}"
    return f"all {whole} {_plural(noun)}" if part == whole > 0 else f"{part} of {whole} {_plural(noun)}"


def _plural(noun: str) -> str:
    return f"{noun}{'es' if noun.endswith('x') else 's'}"
