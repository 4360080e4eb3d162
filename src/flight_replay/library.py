"""The face of the package for programs and notebooks: what ``import flight_replay`` offers.

    recording = flight_replay.read_log("flight.bin")
    route = flight_replay.fit(recording.track, speed_m_s="recorded")
    replay = flight_replay.replay(route, speedup=10)
    print(replay.outcome.errors.position_m.statistics)
    flight_replay.figure(route, replay)

Each step is that of the command line. Units are SI, angles degrees, as the names say.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

from flight_replay.cli.keyword_options import check_kind, check_planning, keyword_options
from flight_replay.cli.plan_step import Planner
from flight_replay.events import Event, ignore
from flight_replay.exceptions import MissionError
from flight_replay.geometry.flight_errors import FlightErrors
from flight_replay.logs.track import Track
from flight_replay.mission.items import Home
from flight_replay.output.comparison import compare_tracks
from flight_replay.planning.altitude import Recorded
from flight_replay.planning.route import Route
from flight_replay.planning.vehicle_limits import VehicleLimits
from flight_replay.signals import as_keyboard_interrupt

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from flight_replay.cli.flight_result import FlightResult

_TRACK, _ROUTE = "read_log(path).track", "plan(read_log(path).track)"
"""Where arguments come from."""


def plan(  # noqa: PLR0913
    track: Track,
    *,
    route: Literal["spacing", "fit"] = "spacing",
    mode: Literal["auto", "guided"] = "auto",
    spacing_m: float = 3.0,
    max_points: int = 100,
    altitude_m: float | Recorded = 30.0,
    floor_m: float = 5.0,
    speed_m_s: float | Recorded | None = None,
    pace: float = 1.0,
    heading: Literal["vehicle", "recorded"] | None = None,
    limits: VehicleLimits | None = None,
) -> Route:
    """The route that flies a track again, with the errors that the flight model predicts.

    Args:
        track: At least one fix, such as ``read_log(path).track``.
        route: A waypoint every ``spacing_m``, or a fit to the whole flight.
        mode: A mission for AUTO, or a motion to follow in step in GUIDED.
        spacing_m: Least distance of waypoints, for "spacing".
        max_points: Maximum number of waypoints.
        altitude_m: Metres above home, or as recorded.
        floor_m: Recorded altitudes below this are flown at it.
        speed_m_s: As recorded, so fast, or None for the vehicle's own.
        pace: For "guided": 0.5 follows the recording at half its speed.
        heading: The vehicle's own way, or as recorded; None is "recorded" for "guided", else "vehicle".
        limits: Those of the vehicle that will fly it; ArduCopter's defaults if None.

    Raises:
        MissionError: The track cannot be flown like that, or an argument is not what it may be.
    """
    how = {"route": route, "mode": mode, "heading": heading, "pace": pace}
    places = {"spacing_m": spacing_m, "max_points": max_points}
    motion = {"altitude_m": altitude_m, "floor_m": floor_m, "speed_m_s": speed_m_s}
    options = keyword_options({**how, **places, **motion})
    check_planning(options, track)
    if not isinstance(limits, VehicleLimits | None):
        raise MissionError(f"limits must be VehicleLimits or None, not {type(limits).__name__}")
    return Planner(options, track, ignore).route(limits or VehicleLimits())


def fit(
    track: Track,
    *,
    max_points: int = 100,
    altitude_m: float | Recorded = 30.0,
    speed_m_s: float | Recorded | None = None,
) -> Route:
    """The whole flight in few straight and spline waypoints: ``plan`` with ``route="fit"``.

    Raises:
        MissionError: The track cannot be flown like that, or an argument is not what it may be.
    """
    return plan(track, route="fit", max_points=max_points, altitude_m=altitude_m, speed_m_s=speed_m_s)


def replay(  # noqa: PLR0913
    route: Route,
    vehicle: str | None = None,
    *,
    duration_s: float | None = None,
    speedup: float | None = None,
    takeoff_altitude_m: float = 30.0,
    land: bool = False,
    yes: bool = False,
    listener: Callable[[Event], None] = ignore,
) -> FlightResult:
    """Fly a route, and measure how near the flight is to the recording.

    Returns once RTL is confirmed, or the vehicle has landed; RTL is commanded on every way out.

    Args:
        route: What ``plan`` or ``fit`` made.
        vehicle: A connection string; None starts a simulator.
        duration_s: How long to fly the mission, or to follow; None flies all of it.
        speedup: How many times faster than real time a simulator runs.
        takeoff_altitude_m: Metres above home.
        land: Wait until it has landed.
        yes: Arm a real vehicle without asking at the terminal.
        listener: Called with every event of the flight.

    Raises:
        MissionError: An argument is not what it may be.
        FlightReplayError: The flight ended before the mission began.
    """
    from flight_replay.cli.flight_step import fly
    from flight_replay.output.console.console import open_console

    _check_flown(route, vehicle)
    mode = "auto" if route.reference is None else "guided"
    where = {"mode": mode, "connect": vehicle, "speedup": speedup, "takeoff_altitude_m": takeoff_altitude_m}
    options = keyword_options({**where, "duration_s": duration_s, "land": land, "yes": yes})
    with as_keyboard_interrupt(exits=False), open_console(sys.stderr, quiet=True) as console:
        _, flown = fly(options, _home(route), lambda _limits: route, console, listener)
    assert flown is not None  # Only a dry run has no flight.
    return flown


def _check_flown(route: object, vehicle: object) -> None:
    """Refuse what is no route, and what is no connection string."""
    check_kind(route, Route, "route", _ROUTE)
    if vehicle is not None:
        check_kind(vehicle, str, "vehicle", "'udpin:127.0.0.1:14550'")


def _home(route: Route) -> Home:
    """Where a simulator starts for a route."""
    first = route.mission.waypoints[0][1]
    return route.mission.home or Home(first.lat_deg, first.lon_deg, 0.0)


def errors(recorded: Track, flown: Track) -> FlightErrors:
    """The errors of a flown track against a recorded one, over what it covers of that.

    Raises:
        MissionError: One of them is not a Track.
        LogError: One of them does not move, or they are not of one motion.
    """
    for name, track in (("recorded", recorded), ("flown", flown)):
        check_kind(track, Track, name, _TRACK)
    return compare_tracks(recorded, flown).errors


def figure(route: Route, flight: FlightResult | None = None) -> Figure:
    """A page of plots: paths, errors, altitude and speed; shown by notebooks, or saved with ``savefig``.

    Raises:
        MissionError: An argument is not what it may be.
    """
    from flight_replay.cli.flight_result import FlightResult
    from flight_replay.output.charts.plot import replay_figure

    check_kind(route, Route, "route", _ROUTE)
    if flight is not None:
        check_kind(flight, FlightResult, "flight", "replay(route)")
    return replay_figure(route, None if flight is None else flight.outcome)
