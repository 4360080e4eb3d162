"""How a worker that ends itself tells why: an event of Dask's, which outlives it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from flight_replay.cli.many.log_content import LogContent
from flight_replay.output.many.result_store import FlightKey

TOPIC = "flight-replay-many"


def teller(log: LogContent, flight: FlightKey | None) -> Callable[[], None]:
    """What tells the scheduler that a flight takes too long; without a flight, that its log does.

    It may be called by any thread; only the one that does the work knows Dask's worker, and asks for it here.
    """
    from distributed import get_worker

    try:
        worker = get_worker()
    except ValueError:  # nobody is there to be told
        return lambda: None
    return lambda: worker.log_event(TOPIC, _message(log, flight))


def was_late(events: Iterable[tuple[float, Any]], log: LogContent, flight: FlightKey | None) -> bool:
    """Whether one of the events that were told says so of this flight."""
    wanted = _message(log, flight).items()
    return any(wanted <= told.items() for _, told in events)  # Dask adds the worker's name


def _message(log: LogContent, flight: FlightKey | None) -> dict[str, str]:
    return {"log": log.file.path, "flight": repr(flight)}
