"""livemap*.py and tiles.py: the live map's data, its page and its server, without a browser."""

from __future__ import annotations

import math
import socket
import threading
import time
import urllib.request
from typing import Any

import numpy as np
import pytest
from bokeh.document import Document
from bokeh.models import ColumnDataSource
from bokeh.models.renderers import TileRenderer

from flight_replay.events import (
    DistanceToWaypoint,
    Event,
    Finished,
    LinkLost,
    Phase,
    PhaseStarted,
    VehicleState,
    Waiting,
    WaypointReached,
)
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.output.charts import map_tiles
from flight_replay.output.charts.series import curves
from flight_replay.output.live_map.data import Follower, LiveData
from flight_replay.output.live_map.page import Page, readings_html
from flight_replay.output.live_map.server import LiveMap
from flight_replay.planning.spacing import spaced_route
from tests.helpers.made_replays import FRAME, eight, replay


def state(
    north_m: float, east_m: float, time_s: float, *, mode: str = "AUTO", heading_deg: float | None = 90.0
) -> VehicleState:
    """The vehicle at a place of the made-up frame."""
    lat_deg, lon_deg = FRAME.to_degrees([north_m, east_m])
    return VehicleState(
        time_s, float(lat_deg), float(lon_deg), 29.8, (3.0, 4.0, 0.0), heading_deg, mode, True, 12.4, 83.0
    )


@pytest.fixture
def data() -> LiveData:
    """The live data of the made-up replay."""
    return LiveData(replay()[0])


def test_distances_begin_with_the_first_waypoint(data: LiveData) -> None:
    """Before it was reached, and outside AUTO, there is nothing to compare."""
    data.listener(state(1, 0, 50.0))
    data.listener(WaypointReached(1, 60.0))
    data.listener(state(0, 0, 60.0))
    data.listener(state(0, 0, 61.0, mode="RTL"))
    before, at_first, home = data.points(0)
    assert math.isnan(before.elapsed_s)
    assert at_first.elapsed_s == 0
    assert at_first.in_space_m == pytest.approx(0, abs=1e-3)
    assert at_first.in_time_m == pytest.approx(0, abs=1e-3)
    assert math.isnan(home.in_space_m)
    assert [before.north_m, before.east_m] == pytest.approx([1, 0], abs=1e-3)


def test_distance_in_time_is_that_of_equal_times(data: LiveData) -> None:
    """A vehicle that flies the eight 10 % slower falls behind by as much."""
    recorded, slow = eight(), eight(slower=1.1)
    data.listener(WaypointReached(1, 100.0))
    for n in range(0, 300, 5):
        north_m, east_m = slow.north_east_m(FRAME)[n]
        data.listener(state(north_m, east_m, float(slow.time_s[n])))
    late = data.points(0)
    where = recorded.north_east_m(FRAME)
    there = [np.interp(late[20].elapsed_s + 100, recorded.time_s, where[:, axis]) for axis in (0, 1)]
    assert late[20].in_time_m == pytest.approx(math.dist(there, slow.north_east_m(FRAME)[100]), abs=0.01)
    assert math.isnan(late[-1].in_time_m)
    assert max(point.in_space_m for point in late) < 0.05


def test_a_crossing_path_does_not_lend_its_other_branch() -> None:
    """At the crossing of the eight, the vehicle is held to the branch that it is on."""
    path = eight().north_east_m(FRAME)
    follower = Follower(path)
    aside = [follower.distance_m(place + np.array([0.0, 2.0])) for place in path]
    assert max(aside) <= 2.001


def test_a_sharp_turn_does_not_carry_the_follower_away() -> None:
    """Just before the way turns back on itself, the way back is near too; the distance stays true."""
    out = np.column_stack([np.linspace(0, 50, 101), np.zeros(101)])
    back = np.column_stack([np.linspace(50, 0, 101), np.full(101, 0.5)])
    follower = Follower(np.vstack([out, back]))
    places = np.vstack([out, back]) + np.array([0.0, 0.4])
    assert max(follower.distance_m(place) for place in places) < 0.6


def test_a_single_fix_can_be_followed() -> None:
    """A hovering log has a map too."""
    assert Follower(np.zeros((1, 2))).distance_m(np.array([3.0, 4.0])) == pytest.approx(5)


def test_the_target_is_the_waypoint_flown_to(data: LiveData) -> None:
    """Known while the vehicle heads for one; items without a place, and the end, have none."""
    assert data.target_m() is None
    data.listener(DistanceToWaypoint(1, 3.0, 60))
    assert data.target_m() == pytest.approx((0, 0), abs=1e-3)
    data.listener(DistanceToWaypoint(999, 3.0, 60))
    assert data.target_m() is None
    data.listener(DistanceToWaypoint(1, 3.0, 60))
    data.listener(Finished("duration"))
    assert data.target_m() is None


def open_page(data: LiveData, tile_event: threading.Event | None = None) -> tuple[Page, Document]:
    """A page in a document, as a browser would get it."""
    page = Page(data, curves(replay()[0]), FRAME, tile_event or threading.Event())
    document = Document()
    page.fill(document)
    return page, document


def source(document: Document, name: str) -> Any:
    """The data of a named source."""
    model = document.get_model_by_name(name)
    assert isinstance(model, ColumnDataSource)
    return model.data


def test_a_page_that_comes_late_shows_what_has_been_flown(data: LiveData) -> None:
    """Trail, errors, heading and target are there at once, and go on with each tick."""
    data.listener(WaypointReached(1, 100.0))
    data.listener(state(0, 0, 100.0))
    data.listener(DistanceToWaypoint(2, 3.0, 60))
    page, document = open_page(data)
    assert list(source(document, "trail")["east"]) == [pytest.approx(0, abs=1e-3)]
    assert source(document, "target")["seq"] == ["2"]
    data.listener(state(5, 7, 101.0, heading_deg=None))
    page.tick()
    page.tick()
    assert list(source(document, "trail")["north"])[1:] == [pytest.approx(5, abs=1e-3)]
    assert list(source(document, "errors")["time"]) == [0.0, 1.0]
    assert source(document, "copter")["angle"] == [pytest.approx(math.pi / 2)]
    data.listener(Finished("duration"))
    page.tick()
    assert source(document, "target")["seq"] == []
    assert {root.name for root in document.roots} == {"map", "readings", "space", "time"}


def test_a_page_opened_after_the_flight_raises_no_alarm_when_the_server_goes(data: LiveData) -> None:
    """A page of a flight that goes on does tell a lost connection."""
    _, during = open_page(data)
    data.listener(Finished("duration"))
    _, after = open_page(data)
    assert during.config.notify_connection_status
    assert not after.config.notify_connection_status


def test_a_quiet_moment_sends_nothing(data: LiveData) -> None:
    """A tick without news changes nothing in the document."""
    data.listener(state(0, 0, 100.0))
    page, document = open_page(data)
    changes: list[object] = []
    document.on_change(changes.append)
    page.tick()
    assert changes == []


def test_tiles_are_laid_under_the_map_only_once_the_network_answered(data: LiveData) -> None:
    """No answer, no tiles; an answer, one layer of them."""
    answered = threading.Event()
    page, document = open_page(data, answered)
    assert tile_layers(document) == 0
    answered.set()
    page.tick()
    page.tick()
    assert tile_layers(document) == 1


def tile_layers(document: Document) -> int:
    """How many layers of tiles the map has."""
    chart: Any = document.get_model_by_name("map")
    return sum(isinstance(layer, TileRenderer) for layer in chart.renderers)


@pytest.mark.parametrize(("lat_deg", "lon_deg"), [(47.4, 8.5), (-35.4, 149.2), (0.0, -179.9), (70.0, 20.0)])
def test_tiles_fit_the_local_frame(lat_deg: float, lon_deg: float) -> None:
    """A place 300 m away lies on the tile where web Mercator has it, to a third of a percent."""
    frame = LocalFrame(lat_deg, lon_deg)
    layer = map_tiles.tile_source(frame)
    lat, lon = (float(degrees) for degrees in frame.to_degrees([300.0, 200.0]))
    zoom = 19
    share = (
        (lon + 180) / 360 * 2**zoom,
        (1 + math.asinh(math.tan(math.radians(lat))) / math.pi) / 2 * 2**zoom,
    )
    metre_per_px = layer.initial_resolution / 2**zoom
    east_m = share[0] * 256 * metre_per_px - layer.x_origin_offset
    north_m = share[1] * 256 * metre_per_px - layer.y_origin_offset
    assert east_m == pytest.approx(200, rel=0.007)
    assert north_m == pytest.approx(300, rel=0.007)


def test_the_probe_tells_whether_a_host_answers() -> None:
    """A host that listens is an answer, one that refuses is none."""
    with socket.create_server(("127.0.0.1", 0)) as host:
        assert map_tiles.probe("127.0.0.1", host.getsockname()[1]).wait(10)
        closed_port = host.getsockname()[1]
    assert not map_tiles.probe("127.0.0.1", closed_port).wait(0.2)


def words(*events: Event, data: LiveData) -> str:
    """The readings after some events."""
    for event in events:
        data.listener(event)
    return readings_html(data.status, data.points(0)[-1:])


def test_readings_tell_where_the_flight_stands(data: LiveData) -> None:
    """Phase, waypoint, altitude, speed, battery, distances and trouble; what is not known is left out."""
    assert "planning" in words(data=data)
    assert "prearm: EKF &lt;not&gt; ready" in words(
        PhaseStarted(Phase.PREARM), Waiting(Phase.PREARM, "EKF <not> ready"), data=data
    )
    text = words(
        PhaseStarted(Phase.MISSION),
        DistanceToWaypoint(3, 2.0, 60),
        WaypointReached(1, 100.0),
        state(0, 1, 100.0),
        data=data,
    )
    for said in ("mission", "3 of 60", "29.8 m", "5.0 m/s", "12.4 V 83 %", "Off in space", "1.0 m"):
        assert said in text
    assert "nothing heard for 4 s" in words(LinkLost(4.0), data=data)
    assert "ended: duration" in words(Finished("duration"), data=data)


@pytest.fixture
def no_tiles(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tests ask no tile server for anything."""
    monkeypatch.setattr(map_tiles, "probe", threading.Event)


@pytest.mark.usefixtures("no_tiles")
def test_the_map_is_served_on_loopback_and_needs_nothing_else() -> None:
    """The page and its scripts come from the server itself, at an address of loopback only."""
    with LiveMap(replay()[0]) as live:
        assert live.url.startswith("http://127.0.0.1:")
        assert not live.is_watched
        with urllib.request.urlopen(live.url, timeout=10) as answer:
            page = answer.read().decode()
        port = int(live.url.rsplit(":", 1)[1].strip("/"))
        assert not answers(outside_address(), port)
    assert 'src="/static/js/bokeh' in page
    assert "//cdn" not in page
    assert 'name="viewport"' in page
    assert not answers("127.0.0.1", port)


def outside_address() -> str:
    """An address of this machine that is not loopback, or another one of loopback where there is none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))
        except OSError:
            return "127.0.0.2"
        return str(probe.getsockname()[0])


def answers(host: str, port: int) -> bool:
    """Whether something listens there."""
    try:
        socket.create_connection((host, port), 2).close()
    except OSError:
        return False
    return True


@pytest.mark.usefixtures("no_tiles")
def test_a_page_that_is_closed_harms_nothing() -> None:
    """The map knows who watches; when nobody does any more, events go on being taken."""
    from bokeh.client import pull_session

    with LiveMap(replay()[0]) as live:
        live.listener(state(5, 7, 100.0))
        session = pull_session(url=live.url)
        assert live.is_watched
        assert source(session.document, "copter")["east"] == [pytest.approx(7, abs=1e-3)]
        session.close()
        deadline_s = time.monotonic() + 10
        while live.is_watched and time.monotonic() < deadline_s:
            time.sleep(0.05)
        assert not live.is_watched
        for n in range(1000):
            live.listener(state(5, 7, 101.0 + n))


@pytest.mark.usefixtures("no_tiles")
def test_pages_of_other_sites_may_not_listen() -> None:
    """A page from elsewhere that opens a websocket to the map is refused."""
    request = (
        "GET /ws HTTP/1.1\r\nHost: {host}\r\nOrigin: http://evil.example\r\nUpgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    )
    with LiveMap(replay()[0]) as live:
        host = live.url.split("/")[2]
        with socket.create_connection(("127.0.0.1", int(host.split(":")[1])), 10) as visitor:
            visitor.sendall(request.format(host=host).encode())
            assert visitor.recv(1000).startswith(b"HTTP/1.1 403")


def test_a_route_of_one_waypoint_has_a_map() -> None:
    """A hovering log can be watched too."""
    route = spaced_route(eight().select(slice(0, 1)))
    page = Page(LiveData(route), curves(route), route.covered.frame, threading.Event())
    page.fill(Document())
