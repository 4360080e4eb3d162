"""The steps before the flight: read the log, select the part to fly, plan the route."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from flight_replay.cli.option_combinations import COMMAND_LINE, Wording
from flight_replay.cli.options import Options
from flight_replay.events import Listener, Notice, Progress, ignore
from flight_replay.exceptions import LogError
from flight_replay.logs.flights import Flight, find_flights, select
from flight_replay.logs.log_formats import TELEMETRY_LOG, LogFormat
from flight_replay.logs.plausibility import REASONS, Rejection
from flight_replay.logs.read_log import read_log
from flight_replay.logs.recording import Recording
from flight_replay.logs.sample import default_log
from flight_replay.logs.track import Track
from flight_replay.logs.vehicles import VehicleId
from flight_replay.mission.items import Home
from flight_replay.output.json_summary import reference_summary
from flight_replay.planning.altitude import RECORDED, altitudes_m, home_of
from flight_replay.planning.doubts import check_moves, doubts
from flight_replay.planning.flown_part import flown_part
from flight_replay.planning.prediction import with_prediction
from flight_replay.planning.required_limits import required_limits
from flight_replay.planning.route import Route, route_of
from flight_replay.planning.route_heights import route_heights
from flight_replay.planning.spacing import spaced_route
from flight_replay.planning.top_speed import with_recorded_speed_note, with_speed_note
from flight_replay.planning.unrecorded_ways import unrecorded_notes
from flight_replay.planning.vehicle_limits import VehicleLimits
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.writing.counted import counted

_MANY_BEYOND = 0.05
"""Of all positions: single ones beyond jumps are missed by nobody."""


def read(options: Options, listener: Listener) -> Recording:
    """The log that the options name.

    Raises:
        LogError: The log cannot be read, or holds nothing usable.
    """
    what = "the motion" if options.mode == "guided" else "waypoints"

    def opened(log_format: LogFormat) -> None:
        if not options.info:
            listener(Notice(f"Generating {what} from {log_format.title}..."))

    return read_log(
        default_log() if options.log is None else options.log,
        vehicle=None if options.vehicle is None else VehicleId(*options.vehicle),
        progress=lambda done, total: listener(Progress("log", done, total, "bytes")),
        opened=opened,
    )


def read_recording(options: Options, listener: Listener) -> tuple[Recording, tuple[Flight, ...], Track]:
    """The log, its flights, and the part of its track that the options select; notes are emitted.

    Raises:
        LogError: The log cannot be read, or has no fix in the selected part.
    """
    recording = read(options, listener)
    return recording, *part_of(options, recording, listener)


def part_of(options: Options, recording: Recording, listener: Listener) -> tuple[tuple[Flight, ...], Track]:
    """The flights of a recording, and the part of its track that the options select; notes are emitted.

    Raises:
        LogError: It has no fix in the selected part, or not the times that the options need.
    """
    _check_times(options, recording)
    flights = find_flights(recording.track)
    track = select(recording.track, options.flight, options.from_s, options.to_s)
    for note in (
        *recording.notes,
        *_left_out(recording),
        *_choices(options, recording, flights),
        *doubts(recording, flights, track),
    ):
        listener(Notice(f" {note}"))
    return flights, track


def _check_times(options: Options, recording: Recording) -> None:
    """Refuse what needs the times of a recording that has none."""
    needs = needs_times(options, COMMAND_LINE)
    if needs and not recording.track.timed:
        raise LogError(f"{recording.path} has no times: leave out {needs}")


def needs_times(options: Options, words: Wording) -> str:
    """The options that need the times of a recording, as they were given; nothing if none does."""
    asked = {
        words.setting("mode", "guided"): options.mode == "guided",
        words.setting("speed_m_s", RECORDED): options.speed_m_s == RECORDED,
        words.setting("limits", "recorded"): options.limits == "recorded",
        words.name("from_s"): options.from_s is not None,
        words.name("to_s"): options.to_s is not None,
    }
    return " and ".join(option for option, is_asked in asked.items() if is_asked)


def _left_out(recording: Recording) -> list[str]:
    """How many positions are beyond jumps, where they are so many that a part of the flight is among them."""
    beyond = recording.rejected.get(REASONS[Rejection.JUMP], 0)
    of = len(recording.track) + recording.rejected_total
    if beyond <= _MANY_BEYOND * of:
        return []
    return [f"Left out: {beyond} of {of} positions, which an impossible jump parts from the others"]


def _choices(options: Options, recording: Recording, flights: Sequence[Flight]) -> list[str]:
    """What else of the log could be replayed."""
    notes = []
    if options.vehicle is None and len(recording.vehicles) > 1 and recording.vehicle is not None:
        others = ", ".join(f"{each.id} ({counted(each.fixes, 'fix')})" for each in recording.vehicles[1:])
        notes.append(f"Replaying vehicle {recording.vehicle.id}; choose others with --vehicle: {others}")
    if options.flight is None and len(flights) > 1:
        notes.append(f"The log holds {len(flights)} flights; choose one with --flight, or see --info")
    return notes


class Planner:
    """Plans the route that the options ask for, for the vehicle that will fly it.

    What needs no vehicle's limits is planned at once: a log that cannot be flown is refused before any
    vehicle is started. It is planned again only for a vehicle that does not have ArduCopter's defaults.
    """

    def __init__(
        self, options: Options, track: Track, listener: Listener, source: str = TELEMETRY_LOG.title
    ) -> None:
        """Begin; ``source`` names the log's format.

        Raises:
            MissionError: The track cannot be flown as the options ask.
        """
        self._options, self._track, self._listener, self._source = options, track, listener, source
        self._planned: tuple[VehicleLimits, Route] | None = None
        if options.route == "spacing":
            self._plan(VehicleLimits())

    @property
    def home(self) -> Home:
        """The ground below where the route begins."""
        whole = self._options.route == "fit" or self._options.mode == "guided"
        return home_of(flown_part(self._track)[0] if whole else self._track)

    def route(self, vehicle: VehicleLimits) -> Route:
        """The route for a vehicle; its notes are emitted.

        Raises:
            MissionError: The track cannot be flown as the options ask.
        """
        route = self._plan(vehicle)
        for note in (*vehicle.notes, *_motion_notes(route), *route.notes):
            self._listener(Notice(f" {note}"))
        return replace(route, limits=replace(vehicle, limits=route.limits.limits))

    def _plan(self, vehicle: VehicleLimits) -> Route:
        """The route for a vehicle of these limits, from before if it was planned with the same."""
        wanted = replace(vehicle, vehicle=None)
        if self._planned is None or self._planned[0] != wanted:
            told = self._planned is not None
            listener = ignore if told else self._listener
            route = _planned_route(self._options, self._track, wanted, listener, self._source)
            self._planned = wanted, route
        return self._planned[1]


def _planned_route(
    options: Options, track: Track, vehicle: VehicleLimits, listener: Listener, source: str
) -> Route:
    if options.mode == "guided":
        return _followed_route(options, track, vehicle)
    raised = required_limits(track, vehicle.limits) if options.limits == "recorded" else {}
    limits = replace(vehicle.limits, **raised)
    if options.route == "fit":
        route = _fitted_route(options, track, limits, listener)
    else:
        route = _spaced_route(options, track, limits)
    check_moves(
        route.mission, track, "--max-points" if options.route == "fit" else "--spacing or --max-points"
    )
    listener(Notice(f" Generated {counted(len(route.mission.waypoints), 'waypoint')} from {source}"))
    route = _with_heights(options, route)
    if options.heading == "recorded":
        route = _with_recorded_headings(options, route)
    route = with_prediction(route, options.takeoff_altitude_m)
    route = route.with_notes(*unrecorded_notes(route.covered))
    if isinstance(options.speed_m_s, float):
        route = with_speed_note(route, options.speed_m_s)
    elif options.speed_m_s == RECORDED and options.route == "spacing":  # A fit says where it is late.
        route = with_recorded_speed_note(route)
    return replace(route, required_limits=raised)


def _followed_route(options: Options, track: Track, vehicle: VehicleLimits) -> Route:
    # The solver's libraries take longer to import than all else of a dry run.
    from flight_replay.planning.following.follow_prediction import with_prediction
    from flight_replay.planning.following.followed_route import FollowOptions, followed_route

    limits = vehicle.limits
    follow = FollowOptions(
        pace=options.pace,
        headings=options.heading == "recorded",
        floor_m=options.floor_m,
        approach_m_s=options.speed_m_s if isinstance(options.speed_m_s, float) else limits.wp_speed_m_s,
        drag=vehicle.drag,
    )
    heights_m = altitudes_m(track, options.altitude_m, options.floor_m, options.raise_m)
    route = followed_route(track, heights_m, limits, follow)
    return _with_heights(options, with_prediction(route, options.max_error_m))


def _motion_notes(route: Route) -> list[str]:
    """What the motion that is followed in GUIDED asks of the vehicle."""
    if route.reference is None:
        return []
    motion = reference_summary(route.reference)
    low_m, high_m = round(motion["lowest_m"]), round(motion["highest_m"])
    heights = f"{low_m}" if low_m == high_m else f"{low_m} to {high_m}"
    return [
        f"Generated a motion of {route.path.length_m:.0f} m, up to {motion['top_speed_m_s']:.1f} m/s and "
        f"{motion['top_acceleration_m_s2']:.1f} m/s², {heights} m above home"
    ]


def _with_heights(options: Options, route: Route) -> Route:
    """The route with what it does with heights, and with the time of a climb to its first waypoint."""
    floor_m = options.floor_m if options.altitude_m == RECORDED else None
    heights = route_heights(
        route, takeoff_m=options.takeoff_altitude_m, floor_m=floor_m, raise_m=options.raise_m
    )
    climb_s = heights.climb_s if route.reference is None else 0.0  # That is no part of following.
    duration_s = route.predicted_duration_s + climb_s
    return replace(route, heights=heights, predicted_duration_s=duration_s).with_notes(*heights.notes)


def _with_recorded_headings(options: Options, route: Route) -> Route:
    # Planned with the model of the whole vehicle, which a route without headings need not import.
    from flight_replay.planning.heading import with_recorded_headings

    timed = options.speed_m_s == RECORDED
    return with_recorded_headings(route, options.takeoff_altitude_m, timed=timed)


def _spaced_route(options: Options, track: Track, limits: Limits) -> Route:
    return spaced_route(
        track,
        spacing_m=options.spacing_m,
        max_points=options.max_points,
        altitude_m=options.altitude_m,
        floor_m=options.floor_m,
        raise_m=options.raise_m,
        speed_m_s=options.speed_m_s,
        limits=limits,
    )


def _fitted_route(options: Options, track: Track, limits: Limits, listener: Listener) -> Route:
    from flight_replay.planning.fit import fit

    result = fit(
        track,
        max_points=options.max_points,
        altitude_m=options.altitude_m,
        floor_m=options.floor_m,
        raise_m=options.raise_m,
        speed_m_s=options.speed_m_s,
        limits=limits,
        takeoff_m=options.takeoff_altitude_m,
        progress=lambda done, total: listener(Progress("fit", done, total, "simulations")),
    )
    route = route_of(
        "fit",
        result.mission,
        result.flown,
        heights=result.heights,
        recording=track,
        limits=limits,
        predicted_duration_s=result.predicted_duration_s,
    )
    to_keep_up = _to_keep_up(options) if result.cannot_keep_up else ""
    return replace(route, objective_m=result.objective_m).with_notes(*result.notes, to_keep_up)


def _to_keep_up(options: Options) -> str:
    """What to change for a vehicle that is behind the recording; only simulated ones have limits raised."""
    slower = "follow the recording more slowly, with --mode guided --speed 0.5x"
    if options.limits == "recorded":
        return f"To let it keep up, {slower}."
    if options.connect is None:
        return "To let it keep up on a simulator, add --limits recorded."
    return f"To let it keep up, add --limits recorded if it is simulated, else {slower}."
