"""server.py: the server of the live map."""

from __future__ import annotations

import socket
import threading
import time
import urllib.request
from typing import Any

import pytest

from flight_replay.output.charts import map_tiles
from flight_replay.output.live_map.server import LiveMap
from tests.helpers.made_replays import made_replay, vehicle_at


@pytest.fixture
def no_tiles(monkeypatch: pytest.MonkeyPatch) -> None:
    """No tile server is asked."""
    monkeypatch.setattr(map_tiles, "probe", threading.Event)


@pytest.mark.usefixtures("no_tiles")
def test_the_page_is_served_on_loopback_with_its_scripts() -> None:
    """Page and scripts come from the server itself, which listens on loopback only."""
    with LiveMap(made_replay()[0]) as live:
        assert live.url.startswith("http://127.0.0.1:")
        assert not live.is_watched
        with urllib.request.urlopen(live.url, timeout=60) as answer:
            page = answer.read().decode()
        port = int(live.url.rsplit(":", 1)[1].strip("/"))
        assert not answers(outside_address(), port)
    assert 'src="/static/js/bokeh' in page
    assert "//cdn" not in page
    assert 'name="viewport"' in page
    assert not answers("127.0.0.1", port)


def outside_address() -> str:
    """An address of this machine other than 127.0.0.1, outside loopback if it has one."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))
        except OSError:
            return "127.0.0.2"
        return str(probe.getsockname()[0])


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

    # Where the loop is made current, Python 3.12 and 3.13 warn that there was none before.
    loop = IOLoop(make_current=False)
    with LiveMap(made_replay()[0]) as live:
        live.listener(vehicle_at(5, 7, 100.0))
        session = pull_session(url=live.url, io_loop=loop)
        assert live.is_watched
        copter: Any = session.document.get_model_by_name("copter")
        assert copter.data["east"] == [pytest.approx(7, abs=1e-3)]
        session.close()
        loop.close()
        deadline_s = time.monotonic() + 60
        while live.is_watched and time.monotonic() < deadline_s:
            time.sleep(0.05)
        assert not live.is_watched
        for n in range(1000):
            live.listener(vehicle_at(5, 7, 101.0 + n))


@pytest.mark.usefixtures("no_tiles")
def test_websockets_of_other_sites_are_refused() -> None:
    """A page of another origin cannot read the map."""
    request = (
        "GET /ws HTTP/1.1\r\nHost: {host}\r\nOrigin: http://evil.example\r\nUpgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    )
    with LiveMap(made_replay()[0]) as live:
        host = live.url.split("/")[2]
        with socket.create_connection(("127.0.0.1", int(host.split(":")[1])), 10) as visitor:
            visitor.sendall(request.format(host=host).encode())
            assert visitor.recv(1000).startswith(b"HTTP/1.1 403")
