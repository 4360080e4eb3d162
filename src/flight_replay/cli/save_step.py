"""The files of ``--save``: the mission before the flight, and after it the flown track where one belongs."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from flight_replay.cli.options import Options
from flight_replay.cli.output_step import ReplayResult, problems_of_writing
from flight_replay.logs.flights import find_flights
from flight_replay.planning.route import Route

if TYPE_CHECKING:
    from flight_replay.cli.flight_step import FlightResult
    from flight_replay.logs.recording import Recording
    from flight_replay.logs.track import Track


def save_mission(options: Options, route: Route, recording: Recording) -> None:
    """Write the mission, and the recorded track where the format holds one.

    What vehicles load is complete, with take-off and return, unless it is to be ``--bare``. A motion that is
    followed is no mission: of that there is home, and the line where the format draws one.
    """
    for path in options.save:
        _save(path, options, route, recording)


def save_flown(options: Options, result: ReplayResult) -> list[str]:
    """Write the files once more that hold what was flown too; a sentence for each that fails.

    They were complete before the flight, and stay so where this fails.
    """
    flight = result.flight
    if not options.save or flight is None or not len(flight.record.flown):
        return []
    from flight_replay.mission import formats

    flown = _beside_recording(result.route, flight)
    problems = []
    for path in options.save:
        if path.suffix.lower() in formats.FLOWN_SUFFIXES:
            write = partial(_save, path, options, result.route, result.log, flown)
            problems += problems_of_writing(path, write)
    return problems


def _save(
    path: Path, options: Options, route: Route, recording: Recording, flown: Track | None = None
) -> None:
    from flight_replay.mission import formats
    from flight_replay.mission.standalone import standalone

    flies = path.suffix.lower() in formats.LOADED_SUFFIXES and not options.bare
    mission = standalone(route.mission, options.takeoff_altitude_m) if flies else route.mission
    outline = None if route.reference is None else route.mission
    if outline is not None:
        mission = replace(outline, items=())
    start_utc_s = recording.utc_s_of(route.covered)
    formats.save(path, mission, route.covered, start_utc_s, flown, outline=outline)


def _beside_recording(route: Route, flight: FlightResult) -> Track:
    """The flown track by the clock of the errors, its 0 at the first fix that is saved.

    The vehicle's own clock goes on from where it began with the recording: at the first waypoint.
    """
    began_s, flown = flight.outcome.first_waypoint_s, flight.record.flown
    if began_s is None:
        began_s = flight.record.auto_start_s
    flights, times_s = find_flights(route.covered), route.covered.time_s
    late_s = float(times_s[flights[0].first] - times_s[0]) if flights else 0.0
    return replace(flown, time_s=flown.time_s - began_s + late_s)
