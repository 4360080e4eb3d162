"""Numbers with so many decimals in messages."""

from __future__ import annotations


def fixed_point(value: float, decimals: int) -> str:
    """A number with so many decimals, such as "12.0"; never "-0.0"."""
    return f"{round(value, decimals) + 0.0:.{decimals}f}"
