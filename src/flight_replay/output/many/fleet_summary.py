"""The summary of a table of flights: how many, what failed and why, medians and worst of each error."""

from __future__ import annotations

import heapq
import re
from array import array
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flight_replay.output.many.flight_columns import BOTH_WAYS, ERRORS, GOOD, Row, error_column
from flight_replay.output.result_text import duration_text
from flight_replay.writing.counted import counted

WORST = 5
_WORTH_TELLING = 0.005
_REASONS = 10
_NUMBER = re.compile(r"(?<![\w.-])-?\d+(\.\d+)?\b")
"""By itself, not in an address or a name."""
_PREFIXES = ("flown", "predicted", "planned")


@dataclass(slots=True)
class ErrorSummary:
    """The means of one error over all flights: ``worst`` holds (error, log and flight), the worst first."""

    column: str
    unit: str
    values: array[float] = field(default_factory=lambda: array("d"))
    _worst: list[tuple[float, str]] = field(default_factory=list)

    def add(self, value: float, name: str) -> None:
        """Count a flight's error."""
        self.values.append(value)
        heapq.heappush(self._worst, (value, name))
        if len(self._worst) > WORST:
            heapq.heappop(self._worst)

    @property
    def median(self) -> float:
        """The median over the flights; there is one at least."""
        return float(np.median(np.frombuffer(self.values)))

    @property
    def worst(self) -> list[tuple[float, str]]:
        """The worst few."""
        return sorted(self._worst, reverse=True)


@dataclass(slots=True)
class FleetSummary:
    """What a table holds; copies of logs are counted, but not measured twice."""

    rows: int = 0
    copies: int = 0
    duration_s: float = 0.0
    length_m: float = 0.0
    statuses: Counter[str] = field(default_factory=Counter)
    reasons: Counter[str] = field(default_factory=Counter)
    formats: Counter[str] = field(default_factory=Counter)
    vehicles: Counter[str] = field(default_factory=Counter)
    unfit: int = 0
    errors: dict[str, ErrorSummary] = field(default_factory=dict)

    @property
    def failed(self) -> int:
        """How many rows are no flight that went as asked."""
        return sum(count for status, count in self.statuses.items() if status not in GOOD)

    def add(self, row: Row) -> None:
        """Count a row."""
        self.rows += 1
        if "copy_of" in row:
            self.copies += 1
            return
        self.statuses[row.get("status", "unknown")] += 1
        if "problem" in row:
            self.reasons[reason(row)] += 1
        if row.get("status") in GOOD and not row.get("fit_for_replay"):
            self.unfit += 1
        self.formats[row.get("log_format", "unknown")] += 1
        self.vehicles[row.get("vehicle_type", "unknown")] += 1
        self.duration_s += row.get("duration_s", 0.0)
        self.length_m += row.get("length_m", 0.0)
        for column, unit in MEASURED:
            if column in row:
                error = self.errors.setdefault(column, ErrorSummary(column, unit))
                error.add(row[column], flight_name(row))


def _measured() -> Iterator[tuple[str, str]]:
    for prefix in _PREFIXES:
        for error in BOTH_WAYS if prefix == "planned" else tuple(ERRORS):
            yield error_column(prefix, error, "mean"), ERRORS[error][0]


MEASURED = tuple(_measured())
"""The columns whose medians and worst are told, with their units."""


def summary_of(rows: Iterable[Row]) -> FleetSummary:
    """The summary of some rows, which are read once."""
    summary = FleetSummary()
    for row in rows:
        summary.add(row)
    return summary


def flight_name(row: Row) -> str:
    """A flight for people: its log and number."""
    number = row.get("flight")
    return str(row["log"]) if number is None else f"{row['log']} flight {number}"


def reason(row: Row) -> str:
    """Why a flight failed, without what differs from log to log: its name and numbers."""
    text = str(row["problem"]).replace(str(row["log"]), "LOG")
    return _NUMBER.sub("N", text)


def summary_json(summary: FleetSummary) -> Mapping[str, Any]:
    """The summary for programs."""
    return {
        "rows": summary.rows,
        "copies": summary.copies,
        "statuses": dict(summary.statuses),
        "reasons": dict(summary.reasons),
        "formats": dict(summary.formats),
        "duration_s": round(summary.duration_s, 3),
        "length_m": round(summary.length_m, 3),
        "errors": {
            name: {
                "flights": len(error.values),
                "median": round(error.median, 4),
                "worst": [{"error": round(value, 4), "flight": name} for value, name in error.worst],
            }
            for name, error in summary.errors.items()
        },
    }


def summary_lines(summary: FleetSummary) -> list[str]:
    """The summary for people."""
    lines = [
        f"{counted(summary.rows, 'row')}: " + (_kinds(summary.statuses) or "nothing"),
        f" Recorded: {duration_text(summary.duration_s)}, {summary.length_m / 1000.0:.1f} km",
        f" Formats: {_kinds(summary.formats)}; vehicles: {_kinds(summary.vehicles)}",
    ]
    if summary.copies:
        lines.append(f" Rows of copies of logs, not counted again: {summary.copies}")
    if summary.unfit:
        lines.append(f" Planned flights that are doubtful, see the column doubts: {summary.unfit}")
    if summary.reasons:
        lines.append(" Why not:")
        lines += [f"  {count} x {text}" for text, count in summary.reasons.most_common(_REASONS)]
        if len(summary.reasons) > _REASONS:
            lines.append(
                f"  and {counted(len(summary.reasons) - _REASONS, 'more reason')}; see the column problem"
            )
    flown = any(column.startswith("flown") for column in summary.errors)
    for column, error in summary.errors.items():
        if not (flown and column.startswith("predicted")):
            lines += _error_lines(error)
    return lines


def _kinds(counter: Counter[str]) -> str:
    return ", ".join(f"{count} {name}" for name, count in counter.most_common())


def _error_lines(error: ErrorSummary) -> Iterator[str]:
    title = error.column.removesuffix(f"_mean_{error.unit}").replace("_", " ")
    worst = [(value, name) for value, name in error.worst if value >= _WORTH_TELLING]
    median = f"median {error.median:.2f} {error.unit} of {len(error.values)}"
    yield f" {title.capitalize()}, mean of a flight: {median}{'; worst:' if worst else ''}"
    for value, name in worst:
        yield f"  {value:.2f} {error.unit}  {name}"
