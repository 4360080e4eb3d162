"""The live map of ``--map``, for as long as the flight lasts."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from flight_replay.cli.options import Options
from flight_replay.events import Listener, Notice, combine_listeners
from flight_replay.logs.byte_source import STANDARD_INPUT
from flight_replay.output.console.console import Console
from flight_replay.planning.route import Route

_LOOK_S = 0.5  # Windows notices Ctrl-C between two of them.


@contextmanager
def with_live_map(options: Options, route: Route, console: Console, listener: Listener) -> Iterator[Listener]:
    """The listener, combined with the live map's if ``--map`` was given.

    At a terminal the map is served until Enter is pressed after the flight; that of a dry run is served
    anywhere, until Enter or Ctrl-C is pressed, or the input ends; until Ctrl-C if the input is the log.
    """
    if not options.map:
        yield listener
        return
    from flight_replay.output.live_map.server import LiveMap

    with LiveMap(route, tiles=options.map_tiles) as live_map:
        listener(Notice(f"Live map: {live_map.url}", asked_for=True))
        _open_browser(live_map.url)
        yield combine_listeners(listener, live_map.listener)
        if options.dry_run and options.log == STANDARD_INPUT:
            _wait_for_interrupt(console, "The plan is on the map")
        elif options.dry_run:
            _wait_for_enter(console, "The plan is on the map")
        elif live_map.is_watched and sys.stdin.isatty():
            _wait_for_enter(console, "The flight is over")


def _open_browser(url: str) -> None:
    """Open the page if there is a screen: a browser in the terminal would hide the flight.

    Nothing waits for it, as for the command in ``BROWSER``, which may return only when it is closed.
    """
    has_screen = sys.platform in {"win32", "darwin"} or any(map(os.getenv, ("DISPLAY", "WAYLAND_DISPLAY")))
    if has_screen and sys.stdout.isatty():
        threading.Thread(target=_show, args=(url,), name="flight-replay browser", daemon=True).start()


def _show(url: str) -> None:
    import webbrowser

    with suppress(Exception):  # The address is shown anyway.
        webbrowser.open(url)


def _wait_for_enter(console: Console, why: str) -> None:
    with console.paused(), suppress(KeyboardInterrupt):
        sys.stderr.write(f"{why}. Press Enter to close it: ")
        sys.stderr.flush()
        if not sys.stdin.readline():  # The input has ended: nothing was typed that ends the line.
            sys.stderr.write("\n")


def _wait_for_interrupt(console: Console, why: str) -> None:
    with console.paused(), suppress(KeyboardInterrupt):
        sys.stderr.write(f"{why}. Ctrl-C closes it.\n")
        sys.stderr.flush()
        while True:
            time.sleep(_LOOK_S)
