"""page.py: the page of the live map in a document, without a browser."""

from __future__ import annotations

import math
import threading
from typing import Any

import pytest
from bokeh.document import Document
from bokeh.models import ColumnDataSource
from bokeh.models.renderers import TileRenderer

from flight_replay.events import (
    DistanceToWaypoint,
    Event,
    Finished,
    Following,
    LinkLost,
    Phase,
    PhaseStarted,
    Waiting,
    WaypointReached,
)
from flight_replay.output.charts.series import replay_series
from flight_replay.output.live_map.data import MapData
from flight_replay.output.live_map.page import Page, readings_html
from flight_replay.planning.spacing import spaced_route
from tests.helpers.made_replays import FRAME, figure_of_eight, made_following, made_replay, vehicle_at


@pytest.fixture
def data() -> MapData:
    """The map data of the made-up replay."""
    return MapData(made_replay()[0])


def open_page(data: MapData, tile_event: threading.Event | None = None) -> tuple[Page, Document]:
    """A page in a document, as a browser gets it."""
    page = Page(data, replay_series(made_replay()[0]), FRAME, tile_event or threading.Event())
    document = Document()
    page.fill(document)
    return page, document


def source(document: Document, name: str) -> Any:
    """The data of a named source."""
    model = document.get_model_by_name(name)
    assert isinstance(model, ColumnDataSource)
    return model.data


def test_a_page_opened_in_flight_shows_the_flight_so_far(data: MapData) -> None:
    """Trail, errors, heading and target are there at once, and are updated by each tick."""
    data.listener(WaypointReached(1, 100.0))
    data.listener(vehicle_at(0, 0, 100.0))
    data.listener(DistanceToWaypoint(2, 3.0, 60))
    page, document = open_page(data)
    assert list(source(document, "trail")["east"]) == [pytest.approx(0, abs=1e-3)]
    assert source(document, "target")["seq"] == ["2"]
    data.listener(vehicle_at(5, 7, 101.0, heading_deg=None))
    page.tick()
    page.tick()
    assert list(source(document, "trail")["north"])[1:] == [pytest.approx(5, abs=1e-3)]
    assert list(source(document, "errors")["time"]) == [0.0, 1.0]
    assert source(document, "copter")["angle"] == [pytest.approx(math.pi / 2)]
    data.listener(Finished("duration"))
    page.tick()
    assert source(document, "target")["seq"] == []
    assert {root.name for root in document.roots} == {"map", "readings", "path", "position"}


def test_a_page_opened_after_the_flight_reports_no_lost_connection(data: MapData) -> None:
    """During the flight it does report one."""
    _, during = open_page(data)
    data.listener(Finished("duration"))
    _, after = open_page(data)
    assert during.config.notify_connection_status
    assert not after.config.notify_connection_status


def test_a_tick_without_events_sends_nothing(data: MapData) -> None:
    """The document does not change."""
    data.listener(vehicle_at(0, 0, 100.0))
    page, document = open_page(data)
    changes: list[object] = []
    document.on_change(changes.append)
    page.tick()
    assert changes == []


def test_tiles_are_added_once_the_tile_server_has_answered(data: MapData) -> None:
    """One layer, and none before."""
    answered = threading.Event()
    page, document = open_page(data, answered)
    assert tile_layers(document) == 0
    answered.set()
    page.tick()
    page.tick()
    assert tile_layers(document) == 1


def tile_layers(document: Document) -> int:
    """Number of tile layers of the map."""
    chart: Any = document.get_model_by_name("map")
    return sum(isinstance(layer, TileRenderer) for layer in chart.renderers)


def readings(*events: Event, data: MapData) -> str:
    """The readings after some events."""
    for event in events:
        data.listener(event)
    return readings_html(data.status, data.points(0)[-1:])


def test_readings_show_the_status(data: MapData) -> None:
    """Phase, waypoint, altitude, speed, battery, errors and warning; what is not known is left out."""
    assert "planning" in readings(data=data)
    assert "prearm: EKF &lt;not&gt; ready" in readings(
        PhaseStarted(Phase.PREARM), Waiting(Phase.PREARM, "EKF <not> ready"), data=data
    )
    text = readings(
        PhaseStarted(Phase.MISSION),
        DistanceToWaypoint(3, 2.0, 60),
        WaypointReached(1, 100.0),
        vehicle_at(0, 1, 100.0),
        data=data,
    )
    for value in ("mission", "3 of 60", "29.8 m", "5.0 m/s", "12.4 V 83 %", "Path error", "1.0 m"):
        assert value in text
    assert "link lost" in readings(LinkLost(4.0), data=data)
    assert "ended: duration" in readings(Finished("duration"), data=data)


def test_a_recording_that_is_followed_has_its_own_readings_and_times() -> None:
    """How far it is followed, whether it waits, and the recording's time below the errors."""
    route = made_following()[0]
    data = MapData(route)
    text = readings(Following(100.0, 24.0, 110.0, 0.2, waiting=False), data=data)
    assert "Following" in text
    assert "24 of 110 s" in text
    assert "Waiting for the vehicle" in readings(Following(101.0, 24.5, 110.0, 3.2, waiting=True), data=data)
    page, document = Page(data, replay_series(route), route.frame, threading.Event()), Document()
    page.fill(document)
    for name in ("path", "position"):
        chart: Any = document.get_model_by_name(name)
        assert chart.xaxis[0].axis_label == "time of the recording (s)"
    assert len(source(document, "target")["east"]) == 1


def test_a_route_of_one_waypoint_has_a_page() -> None:
    """A log of a hover has a map too."""
    route = spaced_route(figure_of_eight().select(slice(0, 1)))
    page = Page(MapData(route), replay_series(route), route.covered.frame, threading.Event())
    page.fill(Document())
