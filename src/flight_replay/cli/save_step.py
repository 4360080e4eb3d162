"""The files of ``--save``: the mission before the flight, and after it the flown track where one belongs."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flight_replay.cli.options import Options
from flight_replay.cli.output_step import ReplayResult, problems_of_writing
from flight_replay.output.outcome import followed_part
from flight_replay.planning.flown_part import flown_fixes, flown_part
from flight_replay.planning.route import Route

if TYPE_CHECKING:
    from flight_replay.cli.flight_result import FlightResult
    from flight_replay.logs.recording import Recording
    from flight_replay.logs.track import Track


def save_mission(options: Options, route: Route, recording: Recording, track: Track) -> None:
    """Write the mission, and the recorded track where the format holds one.

    That is ``track``: all of the recording that was selected, whatever of it the route covers. What vehicles
    load is complete, with take-off and return, unless it is to be ``--bare``. A motion that is followed is no
    mission: of that there is home, and the line where the format draws one.
    """
    for path in options.save:
        _save(path, options, route, recording, track)


def save_flown(options: Options, result: ReplayResult, track: Track) -> list[str]:
    """Write the files once more that hold what was flown beside ``track``; a sentence for each that fails.

    They were complete before the flight, and stay so where this fails.
    """
    flight, files = result.flight, files_of_flown(options)
    if not files or flight is None or not len(flight.record.flown):
        return []
    flown = _beside_recording(track, result.route, flight)
    problems = []
    for path in files:
        write = partial(_save, path, options, result.route, result.log, track, flown)
        problems += problems_of_writing(path, write)
    return problems


def files_of_flown(options: Options) -> list[Path]:
    """The files of ``--save`` that hold what was flown."""
    if not options.save:
        return []
    from flight_replay.mission import formats

    return [path for path in options.save if path.suffix.lower() in formats.FLOWN_SUFFIXES]


def _save(  # noqa: PLR0913, PLR0917
    path: Path,
    options: Options,
    route: Route,
    recording: Recording,
    track: Track,
    flown: Track | None = None,
) -> None:
    from flight_replay.mission import formats
    from flight_replay.mission.standalone import standalone

    flies = path.suffix.lower() in formats.LOADED_SUFFIXES and not options.bare
    mission = standalone(route.mission, options.takeoff_altitude_m) if flies else route.mission
    outline = None if route.reference is None else route.mission
    if outline is not None:
        mission = replace(outline, items=())
    formats.save(path, mission, track, recording.utc_s_of(track), flown, outline=outline)


def _beside_recording(track: Track, route: Route, flight: FlightResult) -> Track:
    """The flown track by the clock of the errors, put on the recording's; its 0 is at the first fix saved.

    For a mission that is the vehicle's own clock from the first waypoint on, for a motion that of the
    targets, which waited for the vehicle, kept a pace, and took their time where none was recorded. What was
    recorded between two flights is not flown: there the recording's clock goes on alone.
    """
    record = flight.record
    if record.recording_s is None:
        began_s = flight.outcome.first_waypoint_s
        flown = record.flown
        clock_s = flown.time_s - (record.auto_start_s if began_s is None else began_s)
        fixes_s = flown_part(track)[0].time_s
        fixes_s = fixes_s - fixes_s[0]
    else:
        flown, clock_s = followed_part(record.flown, record.recording_s)
        fixes_s = route.wanted.time_s
    ahead_s = track.time_s[flown_fixes(track)] - track.time_s[0] - fixes_s
    return replace(flown, time_s=clock_s + np.interp(clock_s, fixes_s, ahead_s))
