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
    """A mission, the recorded fixes that it covers, and what is known of it before it is flown.

    ``recorded`` is what of ``covered`` was flown, ``wanted`` the same as a replay is measured with: in
    metres around ``frame``, its clock counting from its first fix, its heights as wanted; ``planned_up_m``
    are those that the mission asks for at its fixes, where the vehicle cannot climb as fast as wanted.
    ``recording`` is the flown part of all that the route was made from. ``planned_error`` is the path error
    of the mission's path, ``predicted_duration_s`` the time in AUTO, or of following, ``predicted`` the
    errors of the flight where the planning simulated it, ``predicted_flight`` that flight, by the clock of
    ``wanted``. ``reference`` is the motion to follow in GUIDED,
    where the mission is only its outline, and is not uploaded, ``pace`` times as fast as recorded: the clock
    of ``wanted`` is that of the reference. ``required_limits`` are the fields of
    ``Limits`` to raise on the vehicle before it flies, in SI units; ``objective_m`` is what a fit made
    small; ``limits`` are those that the plan is made with; ``heights`` says what the route does with them;
    ``notes`` are sentences for people.
    """

    method: str
    mission: Mission
    covered: Track
    recorded: Track
    wanted: Movement
    planned_up_m: Floats
    recording: Track
    path: Path
    planned_error: PathErrors
    predicted_duration_s: float
    predicted: FlightErrors | None = None
    predicted_flight: Movement | None = None
    objective_m: float | None = None
    reference: ReferenceMotion | None = None
    pace: float = 1.0
    required_limits: Mapping[str, float] = field(default_factory=dict)
    limits: VehicleLimits = field(default_factory=VehicleLimits)
    heights: RouteHeights | None = None
    notes: tuple[str, ...] = ()

    @property
    def frame(self) -> LocalFrame:
        """The local metric frame of all measures, around the first covered fix."""
        return self.covered.frame


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
    path = planned_path(mission, covered.frame)
    recorded, _ = flown_part(covered)
    heights = heights or Heights(covered.alt_m, covered.alt_m)
    flown = flown_fixes(covered)  # By the recorded heights: a pause on the ground is none in the air.
    wanted = movement_of(replace(recorded, alt_m=heights.wanted_m[flown]), covered.frame)
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
        predicted_duration_s=duration_s(mission, path, limits or Limits())
        if predicted_duration_s is None
        else predicted_duration_s,
    )


def movement_of(track: Track, frame: LocalFrame, start_s: float | None = None) -> Movement:
    """A track in metres around ``frame``, its clock counting from ``start_s``, or else its first fix."""
    begin_s = (track.time_s[0] if len(track) else 0.0) if start_s is None else start_s
    places_m = track.north_east_m(frame)
    return Movement(track.time_s - begin_s, places_m, track.alt_m, track.heading_deg, track.timed)
