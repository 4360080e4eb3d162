"""Where the work is done: processes on this machine, or a Dask cluster; all of that is Dask's."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING

from flight_replay.exceptions import FlightReplayError

if TYPE_CHECKING:
    from distributed import Client

_CONNECT_S = 30.0
_CLOSE_S = 5.0
_RETRIED_AFTER_LOST_WORKERS = 1
_KEPT_BYTES = 32 << 20
_SETTINGS = {
    "distributed.scheduler.allowed-failures": _RETRIED_AFTER_LOST_WORKERS,
    "distributed.worker.daemon": False,  # a flight starts processes
    "distributed.worker.preload": ["flight_replay.cli.many.worker_process"],
    # With Dask's own, 64 kB, larger arrays come from the system and go back to it, a fifth of the time.
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": _KEPT_BYTES,
    "distributed.nanny.pre-spawn-environ.MALLOC_MMAP_THRESHOLD_": _KEPT_BYTES,
}
_NO_DASK = 'flight-replay-many needs Dask; install it with: pip install "flight-replay[many]"'


def check_dask() -> None:
    """Refuse a run without Dask.

    Raises:
        FlightReplayError: It is not installed.
    """
    if find_spec("dask") is None or find_spec("distributed") is None:
        raise FlightReplayError(_NO_DASK)


@contextmanager
def dask_client(scheduler: str | None, workers: int | None) -> Iterator[Client]:
    """A client of the scheduler at an address, or of one of its own with a process for each worker.

    A flight whose worker died is tried once more on such processes; on another scheduler that is said by
    its own ``distributed.scheduler.allowed-failures``.

    Raises:
        FlightReplayError: Dask is not installed, or no scheduler answers at the address.
    """
    try:
        import dask
        from distributed import Client, LocalCluster
    except ImportError as error:
        raise FlightReplayError(_NO_DASK) from error
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    logging.getLogger("tornado").setLevel(logging.CRITICAL)
    if scheduler is not None:
        with _connected(scheduler) as client:
            yield client
        return
    _silence_resource_tracker()
    with (
        dask.config.set(_SETTINGS),
        LocalCluster(
            n_workers=workers or cores(),
            threads_per_worker=1,
            processes=True,
            dashboard_address="127.0.0.1:0",  # Dask opens a port even for no dashboard
            scheduler_kwargs={"dashboard": False},
            silence_logs=logging.CRITICAL,
        ) as cluster,
        Client(cluster) as client,
    ):
        yield client


def _silence_resource_tracker() -> None:
    """Keep Python's process that frees semaphores from warning, after an interrupt, that it has to."""
    given = os.environ.get("PYTHONWARNINGS")
    os.environ["PYTHONWARNINGS"] = ",".join(filter(None, [given, "ignore:resource_tracker:UserWarning"]))


@contextmanager
def _connected(scheduler: str) -> Iterator[Client]:
    from distributed import Client

    try:
        client = Client(scheduler, timeout=_CONNECT_S)
    except (OSError, ValueError) as error:
        raise FlightReplayError(
            f"no Dask scheduler answers at {scheduler}; start one with: dask scheduler"
        ) from error
    try:
        yield client
    finally:
        client.close(_CLOSE_S)


def cores() -> int:
    """How many cores this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1
