"""Two tables of the same flights compared: what became better, and what became worse."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from flight_replay.exceptions import FlightReplayError
from flight_replay.output.many.fleet_summary import flight_name
from flight_replay.output.many.flight_columns import ERRORS, GOOD, Row, error_column
from flight_replay.writing.counted import counted, counted_of

_COMPARED = ("mean", "p95")  # One position decides a maximum: it differs from flight to flight.
_DEG_PER_M = 10.0
"""A tolerance of 0.2 m is one of 2 degrees."""
_MOST_LINES = 20
_Flight = tuple[str, int | None, int | None, int | None]


@dataclass(frozen=True, slots=True)
class Tolerance:
    """Differences that are none: up to ``metres``, ten times that in degrees, or a share of the old error."""

    metres: float = 0.2
    share: float = 0.1

    def of(self, old: float, unit: str) -> float:
        """The tolerance of an error that was ``old``."""
        return max(self.metres * (_DEG_PER_M if unit == "deg" else 1.0), self.share * abs(old))


@dataclass(frozen=True, slots=True)
class Change:
    """A flight that changed: what of it, in words, and whether to the worse."""

    flight: str
    text: str
    worse: bool
    size: float


@dataclass(slots=True)
class FleetComparison:
    """What became of the flights of an old table in a new one."""

    flights: int = 0
    changes: list[Change] = field(default_factory=list)
    only_new: int = 0

    @property
    def worse(self) -> list[Change]:
        """What became worse, the greatest change first."""
        return sorted((each for each in self.changes if each.worse), key=lambda each: -each.size)

    @property
    def better(self) -> list[Change]:
        """What became better, likewise."""
        return sorted((each for each in self.changes if not each.worse), key=lambda each: -each.size)


def compare_tables(old: Iterable[Row], new: Iterable[Row], tolerance: Tolerance) -> FleetComparison:
    """Compare two tables flight by flight; a flight is known by the content of its log, and its number.

    Raises:
        FlightReplayError: A table has a flight with several sets of options, or they have none in common.
    """
    before, after = _by_flight(old, "OLD"), _by_flight(new, "NEW")
    if not before.keys() & after.keys():
        raise FlightReplayError("the two tables have no flight in common; were they made from the same logs?")
    comparison = FleetComparison(only_new=len(after.keys() - before.keys()))
    for key, row in before.items():
        comparison.flights += 1
        comparison.changes += _changes(row, after.get(key), tolerance)
    return comparison


def _by_flight(rows: Iterable[Row], name: str) -> dict[_Flight, Row]:
    """What is compared of each flight."""
    flights: dict[_Flight, Row] = {}
    for row in rows:
        sha256 = row.get("log_sha256")
        if sha256 is None or "copy_of" in row:
            continue
        key = (sha256, row.get("vehicle_system"), row.get("vehicle_component"), row.get("flight"))
        if key in flights and flights[key].get("options_id") != row.get("options_id"):
            raise FlightReplayError(
                f"the table {name} holds {flight_name(row)} with several sets of options; "
                "write each set to a table of its own"
            )
        flights[key] = {column: value for column, value in row.items() if column in _NEEDED}
    return flights


def _changes(old: Row, new: Row | None, tolerance: Tolerance) -> Iterator[Change]:
    flight = flight_name(old)
    if new is None:
        yield Change(flight, "is missing in the new table", True, float("inf"))
        return
    before, after = _outcome(old), _outcome(new)
    was_good, is_good = old.get("status") in GOOD, new.get("status") in GOOD
    if was_good != is_good or (was_good and before != after):
        worse = was_good and (not is_good or _less_flown(old, new))
        yield Change(flight, f"{before}, now {after}", worse, float("inf"))
    if was_good and is_good:
        yield from _error_changes(flight, old, new, tolerance)


def _outcome(row: Row) -> str:
    """How a flight went, in words."""
    if row.get("status") not in GOOD:
        return f"{row.get('status')}: {row.get('problem', 'no reason known')}"
    waypoints = row.get("waypoints", 0)  # none where a motion was followed
    if "flown_by" not in row:
        return f"planned in {counted(waypoints, 'waypoint')}" if waypoints else "planned"
    if not waypoints:
        return str(row.get("ended"))
    return f"{row.get('ended')}, {counted_of(row.get('waypoints_reached', 0), waypoints, 'waypoint')}"


def _less_flown(old: Row, new: Row) -> bool:
    return int(new.get("waypoints_reached", 0)) < int(old.get("waypoints_reached", 0))


def _error_changes(flight: str, old: Row, new: Row, tolerance: Tolerance) -> Iterator[Change]:
    prefix = "flown" if "flown_by" in old and "flown_by" in new else "predicted"
    for error, (unit, _) in ERRORS.items():
        for statistic in _COMPARED:
            column = error_column(prefix, error, statistic)
            if column not in old or column not in new:
                continue
            change = new[column] - old[column]
            if abs(change) > tolerance.of(old[column], unit):
                text = f"{column} {old[column]:.2f}, now {new[column]:.2f}"
                yield Change(flight, text, change > 0, abs(change) / (_DEG_PER_M if unit == "deg" else 1.0))


_NEEDED = frozenset(
    (
        "log",
        "flight",
        "status",
        "problem",
        "ended",
        "waypoints",
        "waypoints_reached",
        "flown_by",
        "options_id",
    )
) | {
    error_column(prefix, error, statistic)
    for prefix in ("flown", "predicted")
    for error in ERRORS
    for statistic in _COMPARED
}


def comparison_lines(comparison: FleetComparison) -> list[str]:
    """The comparison for people: the worst first."""
    worse, better = comparison.worse, comparison.better
    lines = [
        f"{counted(comparison.flights, 'flight')}: {_flights(worse)} became worse, {_flights(better)} better"
        + (f"; only in the new table: {comparison.only_new}" if comparison.only_new else "")
    ]
    for title, changes in (("Worse", worse), ("Better", better)):
        if changes:
            lines.append(f" {title}:")
            lines += [f"  {each.flight}: {each.text}" for each in changes[:_MOST_LINES]]
            if len(changes) > _MOST_LINES:
                lines.append(f"  and {len(changes) - _MOST_LINES} more")
    return lines


def _flights(changes: list[Change]) -> int:
    return len({each.flight for each in changes})


def comparison_json(comparison: FleetComparison) -> Mapping[str, Any]:
    """The comparison for programs."""
    return {
        "flights": comparison.flights,
        "only_new": comparison.only_new,
        "worse": [{"flight": each.flight, "change": each.text} for each in comparison.worse],
        "better": [{"flight": each.flight, "change": each.text} for each in comparison.better],
    }
