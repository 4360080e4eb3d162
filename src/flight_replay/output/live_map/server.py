"""The server of the live map, on loopback only; it serves everything that the page needs.

The server runs in its own thread and only receives events, so that a slow, closed or flooding page does
not hold up the flight or the exit.
"""

from __future__ import annotations

import asyncio
import logging
import secrets
import threading
import time
from types import TracebackType
from typing import Any

from flight_replay.events import Event, Finished
from flight_replay.exceptions import FlightReplayError
from flight_replay.output.charts import map_tiles
from flight_replay.output.charts.series import replay_series
from flight_replay.output.live_map.data import MapData
from flight_replay.output.live_map.page import TICK_MS, Page
from flight_replay.planning.route import Route

_HOST = "127.0.0.1"
_START_TIMEOUT_S = 10.0
_TASKS_END_S = 1.0
_STOP_TIMEOUT_S = 1.5
"""Wall-clock time after which a server that is busy with its pages is left behind."""
_FINAL_UPDATE_S = 3 * TICK_MS / 1000
"""Wall-clock time in which open pages show the last events."""


class LiveMap:
    """Serves the map of one replay at ``url``, which nobody can guess, while the context is open."""

    def __init__(self, route: Route, *, tiles: bool = False) -> None:
        """A map of a route; with ``tiles``, a server on the internet is asked for what is below it."""
        self._wants_tiles = tiles
        self._data = MapData(route)
        self._series = replay_series(route)
        self._frame = route.covered.frame
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="flight-replay map", daemon=True)
        self._loop: Any = None
        self._bokeh: Any = None
        self.url = ""

    def __enter__(self) -> LiveMap:
        self._tiles = map_tiles.probe() if self._wants_tiles else threading.Event()
        self._thread.start()
        if not self._ready.wait(_START_TIMEOUT_S):
            raise FlightReplayError(
                "the live map's server did not start; try again with -v, or leave out --map"
            )
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop once open pages have shown the last events, and how it ended."""
        if error is not None and self._data.status.ended is None:
            ended = "interrupted" if isinstance(error, KeyboardInterrupt) else "failed"
            self._data.listener(Finished(ended, str(error)))
        if self.is_watched:
            time.sleep(_FINAL_UPDATE_S)
        self._loop.add_callback(self._loop.stop)
        self._thread.join(_STOP_TIMEOUT_S)

    def listener(self, event: Event) -> None:
        """Pass an event to the map; takes microseconds."""
        self._data.listener(event)

    @property
    def is_watched(self) -> bool:
        """Whether a browser has the page open."""
        try:
            return any(session.connection_count for session in self._bokeh.get_sessions("/"))
        except RuntimeError:  # A page was opened or closed meanwhile, on the server's thread.
            return True

    def _serve(self) -> None:
        from bokeh.application import Application
        from bokeh.application.handlers.function import FunctionHandler
        from bokeh.server.server import BaseServer
        from bokeh.server.util import bind_sockets
        from tornado.ioloop import IOLoop

        from flight_replay.output.live_map.access import GuardedTornado, bounded_server

        # Browsers request icons that do not exist, and close pages that something is being sent to.
        for name in ("tornado.access", "bokeh.server.views.ws"):
            logging.getLogger(name).setLevel(logging.ERROR)
        asyncio.set_event_loop(asyncio.new_event_loop())
        sockets, port = bind_sockets(_HOST, 0)
        token = secrets.token_urlsafe(16)
        self._bokeh = GuardedTornado({"/": Application(FunctionHandler(self._open_page))}, token, port)
        http = bounded_server(self._bokeh)
        http.add_sockets(sockets)
        self._loop = IOLoop.current()
        server = BaseServer(self._loop, self._bokeh, http)
        server.start()
        self.url = f"http://{_HOST}:{port}/{token}/"
        self._loop.add_callback(self._ready.set)
        self._loop.start()
        server.unlisten()
        server.stop(wait=False)  # Else Bokeh 3.10 serves requests on, and each is an error.
        http.drop_connections()
        end_tasks(self._loop.asyncio_loop)
        self._loop.close(all_fds=True)

    def _open_page(self, document: Any) -> None:
        Page(self._data, self._series, self._frame, self._tiles).fill(document)


def end_tasks(loop: asyncio.AbstractEventLoop) -> None:
    """Cancel what still runs on a stopped loop, and let it end: Bokeh 3.10 leaves its periodic tasks.

    That a page's request ends so is no error to be logged, as it is of threads that still serve.
    """
    tasks = asyncio.all_tasks(loop)
    if not tasks:
        return
    for task in tasks:
        task.cancel()
    loggers = [logging.getLogger(name) for name in ("tornado.access", "tornado.application")]
    ending = threading.get_ident()

    def is_still_serving(record: logging.LogRecord) -> bool:
        return record.thread != ending

    for logger in loggers:
        logger.addFilter(is_still_serving)
    try:
        loop.run_until_complete(asyncio.wait(tasks, timeout=_TASKS_END_S))
    finally:
        for logger in loggers:
            logger.removeFilter(is_still_serving)
