"""From a recorded track to the route that will be flown, and how well that follows the recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.flight_errors import FlightErrors, PathErrors, path_errors
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.geometry.movement import Movement
from flight_replay.geometry.reference_motion import ReferenceMotion
from flight_replay.logs.track import Track
from flight_replay.mission.items import Mission
from flight_replay.mission.path import Path, planned_path
from flight_replay.planning.duration import duration_s
from flight_replay.planning.flown_part import flown_fixes, flown_part
from flight_replay.planning.heights import Heights, RouteHeights
from flight_replay.planning.vehicle_limits import VehicleLimits
from flight_replay.simulator.dynamics.limits import Limits


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """A mission, the recorded fixes that it covers, and what is known of it before it is flown."""

    method: str
    mission: Mission
    covered: Track
    recorded: Track
    """What of ``covered`` was flown."""
    wanted: Movement
    """The same as a replay is measured with: in metres around ``frame``, its heights as wanted, its clock
    counting from its first fix, or that of ``reference``."""
    planned_up_m: Floats
    """The heights that the mission asks for at its fixes; not those wanted, where the vehicle is too slow."""
    recording: Track
    """The flown part of all that the route was made from."""
    path: Path
    planned_error: PathErrors
    """The path error of the mission's path."""
    predicted_duration_s: float
    """The time in AUTO, or of following."""
    predicted: FlightErrors | None = None
    """The errors of the flight, where the planning simulated it."""
    predicted_flight: Movement | None = None
    """That flight, by the clock of ``wanted``."""
    objective_m: float | None = None
    """What a fit made small."""
    reference: ReferenceMotion | None = None
    """The motion to follow in GUIDED; the mission is only its outline then, and is not uploaded."""
    pace: float = 1.0
    """How many times as fast as recorded ``reference`` is."""
    required_limits: Mapping[str, float] = field(default_factory=dict)
    """The fields of ``Limits`` to raise on the vehicle before it flies, in SI units."""
    limits: VehicleLimits = field(default_factory=VehicleLimits)
    """Those that it is planned for."""
    heights: RouteHeights | None = None
    """What the route does with heights."""
    notes: tuple[str, ...] = ()
    """Sentences for people."""

    @property
    def frame(self) -> LocalFrame:
        """The local metric frame of all measures, around the first covered fix."""
        return self.covered.frame

    def with_notes(self, *notes: str) -> Route:
        """The route with more notes; those that are empty are left out."""
        return replace(self, notes=(*self.notes, *filter(None, notes)))


def route_of(  # noqa: PLR0913
    method: str,
    mission: Mission,
    covered: Track,
    *,
    heights: Heights | None = None,
    recording: Track | None = None,
    limits: Limits | None = None,
    predicted_duration_s: float | None = None,
) -> Route:
    """The route of a mission that was made from ``covered``, with its planned error.

    Args:
        method: how the mission was made, by its name.
        mission: at least one waypoint.
        covered: at least one fix.
        heights: those of the covered fixes; the recorded ones if None.
        recording: the track that ``covered`` is a part of.
        limits: what the vehicle may do; ArduCopter's defaults if None.
        predicted_duration_s: seconds in AUTO, if known.
    """
    path, limits = planned_path(mission, covered.frame), limits or Limits()
    heights = heights or Heights(covered.alt_m, covered.alt_m)
    (recorded, _), flown = flown_part(covered), flown_fixes(covered)  # By recorded heights, not those wanted.
    wanted = movement_of(replace(recorded, alt_m=heights.wanted_m[flown]), covered.frame)
    if predicted_duration_s is None:
        predicted_duration_s = duration_s(mission, path, limits)
    return Route(
        method=method,
        mission=mission,
        covered=covered,
        recorded=recorded,
        wanted=wanted,
        planned_up_m=heights.planned_m[flown],
        recording=recorded if recording is None else flown_part(recording)[0],
        path=path,
        planned_error=path_errors(wanted, path.north_east_m),
        predicted_duration_s=predicted_duration_s,
        limits=VehicleLimits(limits),
    )


def movement_of(track: Track, frame: LocalFrame, start_s: float | None = None) -> Movement:
    """A track in metres around ``frame``, its clock counting from ``start_s``, or else its first fix."""
    begin_s = (track.time_s[0] if len(track) else 0.0) if start_s is None else start_s
    places_m = track.north_east_m(frame)
    return Movement(track.time_s - begin_s, places_m, track.alt_m, track.heading_deg, track.timed)
