"""page.py: the page of the live map in a document, without a browser."""

from __future__ import annotations

import math
import threading
from dataclasses import replace
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
    Following,
    LinkLost,
    Phase,
    PhaseStarted,
    ReturnCommanded,
    Waiting,
    WaypointReached,
)
from flight_replay.output.charts.series import replay_series
from flight_replay.output.live_map.data import MapData
from flight_replay.output.live_map.page import Page
from flight_replay.output.live_map.readings import plan_readings, readings_html
from flight_replay.planning.prediction import with_prediction
from flight_replay.planning.route import Route
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
    names = {"map", "readings", "path", "position", "height", "speed"}
    assert {root.name for root in document.roots} == names


def legend_of(document: Document) -> list[str]:
    """The labels of the map's legend."""
    chart: Any = document.get_model_by_name("map")
    return [item.label.value for item in chart.legend[0].items]


def test_the_way_home_is_drawn_apart(data: MapData) -> None:
    """It joins what was flown in AUTO; each line is in the legend once it is there."""
    page, document = open_page(data)
    assert "flown" not in legend_of(document)
    data.listener(WaypointReached(1, 100.0))
    for n in range(3):
        data.listener(vehicle_at(0, n, 100.0 + n))
    page.tick()
    assert legend_of(document)[-1] == "flown"
    data.listener(PhaseStarted(Phase.RETURN))
    data.listener(vehicle_at(0, 1, 104.0, mode="RTL"))
    data.listener(vehicle_at(0, 0, 105.0, mode="RTL"))
    page.tick()
    assert legend_of(document)[-2:] == ["flown", "flown, returning (RTL)"]
    assert list(source(document, "trail")["east"]) == pytest.approx([0, 1, 2], abs=1e-3)
    assert list(source(document, "return")["east"]) == pytest.approx([2, 1, 0], abs=1e-3)
    assert list(source(document, "states")["time"]) == [0, 1, 2, 4, 5]
    assert list(source(document, "errors")["time"]) == [0, 1, 2]


def test_home_moves_to_where_the_vehicle_is_armed(data: MapData) -> None:
    """Until then it is where the plan has it."""
    page, document = open_page(data)
    assert source(document, "home")["north"] == [pytest.approx(0, abs=1e-3)]
    data.listener(replace(vehicle_at(3, 4, 90.0), armed=False))
    data.listener(vehicle_at(5, 6, 91.0))
    data.listener(vehicle_at(7, 8, 92.0))
    page.tick()
    assert source(document, "home")["north"] == [pytest.approx(5, abs=1e-3)]
    assert source(document, "home")["east"] == [pytest.approx(6, abs=1e-3)]


def predicted_plan() -> Route:
    """The made-up plan, with its prediction."""
    return with_prediction(made_replay()[0], 30.0)


def test_a_plan_has_predicted_errors_heights_and_speeds() -> None:
    """All charts have lines before anything is flown, and show what is flown once there is something."""
    route = predicted_plan()
    data = MapData(route)
    page, document = Page(data, replay_series(route), FRAME, threading.Event()), Document()
    page.fill(document)
    assert "predicted" in legend_of(document)
    lines = {}
    for name in ("path", "position", "height", "speed"):
        chart: Any = document.get_model_by_name(name)
        drawn = [line for line in chart.renderers if len(line.data_source.data.get("x", ()))]
        lines[name] = {line.name for line in drawn}
        assert all(np.isfinite(line.data_source.data["y"]).all() for line in drawn)
    assert lines["path"] == lines["position"] == {"predicted"}
    assert {"recorded", "planned", "predicted"} <= lines["height"]
    assert {"recorded", "predicted"} <= lines["speed"]
    time: Any = document.get_model_by_name("path")
    planned = list(time.x_range.renderers)
    data.listener(WaypointReached(1, 100.0))
    data.listener(vehicle_at(0, 0, 100.0))
    page.tick()
    assert time.x_range.renderers != planned
    assert len(time.x_range.renderers) == 4


def test_the_readings_of_a_plan_are_what_is_predicted() -> None:
    """Until there is a vehicle."""
    plan = plan_readings(predicted_plan())
    data = MapData(predicted_plan())
    shown = readings_html(data.status, [], plan)
    for label in (
        "planned",
        "Waypoints",
        "Predicted duration",
        "Predicted path error",
        "Predicted position error",
    ):
        assert label in shown
    data.listener(vehicle_at(0, 0, 100.0))
    assert "Predicted" not in readings_html(data.status, [], plan)


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
    assert "planned" in readings(data=data)
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


@pytest.mark.parametrize(
    ("events", "words"),
    [
        ([ReturnCommanded(confirmed=True), Finished("duration")], ["ended: duration, RTL confirmed"]),
        ([ReturnCommanded(confirmed=True), Finished("duration", landed=True)], ["ended: duration, landed"]),
        (
            [ReturnCommanded(confirmed=False), Finished("link lost", "nothing was heard <for 30 s>")],
            ["ended: link lost, RTL not confirmed", "Problem", "nothing was heard &lt;for 30 s&gt;"],
        ),
        ([Finished("pilot", "the pilot took over")], ["ended: pilot<", "the pilot took over"]),
    ],
)
def test_readings_say_how_it_ended(events: list[Event], words: list[str], data: MapData) -> None:
    """Why, what became of the vehicle, and the problem if there was one."""
    shown = readings(*events, data=data)
    for word in words:
        assert word in shown


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
    document = Document()
    page.fill(document)
    assert document.roots
