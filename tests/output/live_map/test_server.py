"""server.py: the server of the live map."""

from __future__ import annotations

import asyncio
import logging
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Coroutine, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from flight_replay.exceptions import VehicleError
from flight_replay.output.charts import map_tiles
from flight_replay.output.live_map.server import LiveMap, end_tasks
from tests.helpers.machine import outside_address
from tests.helpers.made_replays import made_replay, vehicle_at


@pytest.mark.usefixtures("no_tiles")
def test_the_page_is_served_on_loopback_with_its_scripts() -> None:
    """Page and scripts come from the server itself, which listens on loopback only."""
    with LiveMap(made_replay()[0]) as live:
        assert live.url.startswith("http://127.0.0.1:")
        assert not live.is_watched
        with urllib.request.urlopen(live.url, timeout=60) as answer:
            page = answer.read().decode()
        port = port_of(live)
        assert not answers(outside_address(), port)
    assert f'src="/{token_of(live)}/static/js/bokeh' in page
    assert "//cdn" not in page
    assert 'name="viewport"' in page
    assert not answers("127.0.0.1", port)


def port_of(live: LiveMap) -> int:
    """The port of its address."""
    return int(live.url.split("/")[2].rsplit(":", 1)[1])


def token_of(live: LiveMap) -> str:
    """The token in its address."""
    return live.url.split("/")[3]


def answers(host: str, port: int) -> bool:
    """Whether a TCP connection can be made."""
    try:
        socket.create_connection((host, port), 2).close()
    except OSError:
        return False
    return True


@pytest.mark.usefixtures("no_tiles")
def test_a_closed_page_does_no_harm() -> None:
    """The server knows whether a page is open, and goes on without one."""
    from bokeh.client import pull_session
    from tornado.ioloop import IOLoop

    # From Python 3.14 on there is no current loop unless one is set; 3.12 and 3.13 warn.
    asyncio.set_event_loop(asyncio.new_event_loop())
    loop = IOLoop.current()
    with LiveMap(made_replay()[0]) as live:
        live.listener(vehicle_at(5, 7, 100.0))
        session = pull_session(url=live.url, io_loop=loop)
        assert live.is_watched
        assert session.document is not None
        copter: Any = session.document.get_model_by_name("copter")
        assert copter.data["east"] == [pytest.approx(7, abs=1e-3)]
        session.close()
        loop.close()
        asyncio.set_event_loop(None)
        deadline_s = time.monotonic() + 60
        while live.is_watched and time.monotonic() < deadline_s:
            time.sleep(0.05)
        assert not live.is_watched
        for n in range(1000):
            live.listener(vehicle_at(5, 7, 101.0 + n))


class Interrupted(KeyboardInterrupt):
    """As an interrupted flight raises."""


@pytest.mark.usefixtures("no_tiles")
@pytest.mark.parametrize(
    ("error", "ended"),
    [
        (VehicleError("no arming"), "failed"),
        (KeyboardInterrupt(), "interrupted"),
        (Interrupted(), "interrupted"),
    ],
)
def test_a_flight_that_fails_is_over_on_the_map(error: BaseException, ended: str) -> None:
    """Nothing else tells the page, which would show the last phase for ever."""
    live = LiveMap(made_replay()[0])
    with pytest.raises(type(error)), live:
        raise error
    assert (live._data.status.ended, live._data.status.problem) == (ended, str(error))


WEBSOCKET = (
    "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Protocol: bokeh, none\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
)
PLACES = {"page": ("", ""), "script": ("static/js/bokeh.min.js", ""), "websocket": ("ws", WEBSOCKET)}


def status_of(live: LiveMap, path: str, headers: str) -> int:
    """The status of the server's answer."""
    with socket.create_connection(("127.0.0.1", port_of(live)), 10) as visitor:
        visitor.sendall(f"GET {path} HTTP/1.1\r\n{headers}\r\n".encode())
        return int(visitor.recv(1000).split()[1])


@pytest.fixture(scope="module")
def served() -> Iterator[LiveMap]:
    """A live map without a tile server."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(map_tiles, "probe", threading.Event)
        with LiveMap(made_replay()[0]) as live:
            yield live


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(
    ("host", "allowed"),
    [
        ("Host: 127.0.0.1:{port}\r\n", True),
        ("Host: localhost:{port}\r\n", True),
        ("Host: [::1]:{port}\r\n", True),
        ("Host: evil.example:{port}\r\n", False),
        ("Host: evil.example:{port}\r\nOrigin: http://evil.example:{port}\r\n", False),
        ("Host: 127.0.0.1.evil.example:{port}\r\n", False),
        ("Host: 127.0.0.1\r\n", False),
        ("Host: 127.0.0.1:1\r\n", False),
        ("Host: 127.0.0.2:{port}\r\n", False),
    ],
)
def test_only_loopback_names_are_served(served: LiveMap, place: str, host: str, allowed: bool) -> None:
    """DNS rebinding makes a name of another site lead here; even with the token it is forbidden."""
    path, headers = PLACES[place]
    status = status_of(served, f"/{token_of(served)}/{path}", host.format(port=port_of(served)) + headers)
    assert status == ((101 if place == "websocket" else 200) if allowed else 403)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("prefix", ["/", "/wrong/", "//", "/{token}x/", "/x/{token}/", "/%00/"])
def test_only_who_knows_the_token_is_served(served: LiveMap, place: str, prefix: str) -> None:
    """Page, scripts and websocket are forbidden without it."""
    path, headers = PLACES[place]
    host = f"Host: 127.0.0.1:{port_of(served)}\r\n"
    assert status_of(served, prefix.format(token=token_of(served)) + path, host + headers) == 403


@pytest.mark.usefixtures("no_tiles")
def test_open_pages_are_few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each takes memory; one too many is told to come later, and its scripts are served."""
    monkeypatch.setattr("flight_replay.output.live_map.access._MAX_SESSIONS", 2)
    with LiveMap(made_replay()[0]) as live:
        host = f"Host: 127.0.0.1:{port_of(live)}\r\n"
        asked = [status_of(live, f"/{token_of(live)}/", host) for _ in range(3)]
        script = status_of(live, f"/{token_of(live)}/static/js/bokeh.min.js", host)
    assert (asked, script) == ([200, 200, 503], 200)


def test_each_map_has_a_token_of_its_own(served: LiveMap) -> None:
    """It has at least 128 random bits."""
    with LiveMap(made_replay()[0]) as other:
        assert token_of(other) != token_of(served)
    assert len(token_of(served)) >= 22


def test_websockets_of_other_sites_are_refused(served: LiveMap) -> None:
    """A page of another origin cannot read the map."""
    headers = f"Host: 127.0.0.1:{port_of(served)}\r\nOrigin: http://evil.example\r\n{WEBSOCKET}"
    assert status_of(served, f"/{token_of(served)}/ws", headers) == 403


FLOOD = """
import socket, sys, threading, time
port, path = int(sys.argv[1]), sys.argv[2]
request = f"GET {path} HTTP/1.1\\r\\nHost: 127.0.0.1:{port}\\r\\n\\r\\n".encode()
def ask():
    while True:
        try:
            with socket.create_connection(("127.0.0.1", port), 5) as visitor:
                while True:
                    visitor.sendall(request)
                    visitor.recv(65536)
        except OSError:
            time.sleep(0.01)
silent = []
for _ in range(200):
    try:
        silent.append(socket.create_connection(("127.0.0.1", port), 5))
        silent[-1].sendall(request[:20])
    except OSError:
        pass
    if len(silent) == 30:
        for _ in range(4):
            threading.Thread(target=ask, daemon=True).start()
        print("flooding", flush=True)
time.sleep(60)
"""


@pytest.mark.usefixtures("no_tiles")
@pytest.mark.parametrize("knows_token", [False, True], ids=["a stranger", "a page"])
def test_a_flood_delays_neither_the_flight_nor_the_exit(
    knows_token: bool, caplog: pytest.LogCaptureFixture
) -> None:
    """Requests as fast as they can be sent, and connections that send half a request; nothing is logged."""
    with ExitStack() as stack:
        live = stack.enter_context(LiveMap(made_replay()[0]))
        path = f"/{token_of(live)}/" if knows_token else "/"
        before = descriptors()
        command = [sys.executable, "-c", FLOOD, str(port_of(live)), path]
        with subprocess.Popen(command, stdout=subprocess.PIPE) as flood:
            try:
                assert flood.stdout is not None
                flood.stdout.readline()
                slowest_s = max(listener_takes_s(live, 100.0 + number) for number in range(100))
                opened = descriptors() - before
                began_s = time.monotonic()
                stack.close()
                exit_s = time.monotonic() - began_s
                live._thread.join(10)
            finally:
                flood.kill()
    assert slowest_s < 0.5
    assert exit_s < 5.0
    assert opened < 80
    assert caplog.records == []


def descriptors() -> int:
    """How many files and sockets this process has open, where the system tells."""
    folder = Path("/proc/self/fd")
    return len(list(folder.iterdir())) if folder.exists() else 0


def listener_takes_s(live: LiveMap, time_s: float) -> float:
    """How long an event takes the flight; a moment after the last one."""
    time.sleep(0.02)
    began_s = time.monotonic()
    live.listener(vehicle_at(5, 7, time_s))
    return time.monotonic() - began_s


def test_requests_that_end_with_the_program_are_no_errors(caplog: pytest.LogCaptureFixture) -> None:
    """What Tornado logs of those that are cancelled is kept back; afterwards it logs as before."""
    logger = logging.getLogger("tornado.application")

    async def request() -> None:
        try:
            await asyncio.sleep(3600)
        except asyncio.CancelledError:
            logger.error("Uncaught exception")

    end_with(request())
    assert caplog.records == []
    logger.error("another")
    assert [record.message for record in caplog.records] == ["another"]


def test_servers_that_end_together_log_nothing_of_each_others_requests(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """One that is slow to end keeps its requests' errors back also after another has ended."""
    is_ending, other_ended = threading.Event(), threading.Event()

    async def slow_request() -> None:
        try:
            await asyncio.sleep(3600)
        except asyncio.CancelledError:
            is_ending.set()
            other_ended.wait(10)
            logging.getLogger("tornado.application").error("Uncaught exception")

    slow = threading.Thread(target=end_with, args=(slow_request(),))
    slow.start()
    assert is_ending.wait(10)
    end_with(asyncio.sleep(3600))
    other_ended.set()
    slow.join(10)
    assert not slow.is_alive()
    assert caplog.records == []


def end_with(request: Coroutine[Any, Any, None]) -> None:
    """End a loop in which a request waits."""
    loop = asyncio.new_event_loop()
    task = loop.create_task(request)
    loop.run_until_complete(asyncio.sleep(0))
    end_tasks(loop)
    loop.close()
    assert task.done()
