"""Checks before the upload, and the briefing that a person sees before a real vehicle is armed.

Pure functions on plain data. Home is taken to be the vehicle's position: ArduCopter sets home there
when it arms.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from flight_replay.events import VehicleState
from flight_replay.exceptions import MissionError, VehicleError
from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.geodesy import LocalFrame, distance_m
from flight_replay.mission.fence import FenceArea, FenceType, active_fence_types
from flight_replay.mission.items import Frame, Mission, MissionItem
from flight_replay.vehicle.identity import RTL_END_PARAMETERS, Identity
from flight_replay.vehicle.route_words import MissionWords, RouteWords

MAX_DISTANCE_M = 1000.0
"""The default of ``--max-distance``: how far from the vehicle the first waypoint may be."""
_FLYABLE_FRAMES = frozenset({Frame.ABSOLUTE, Frame.RELATIVE, Frame.TERRAIN})


@dataclass(frozen=True, slots=True)
class Briefing:
    """What a person has to know before a vehicle is armed: degrees, metres, volts, percent.

    ``beginning`` names where the route begins, ``extent`` what there is of it: see ``RouteWords``.
    ``without_failsafe`` is why the vehicle stays out if the link is lost, or empty.
    """

    vehicle: str
    lat_deg: float
    lon_deg: float
    battery_v: float | None
    battery_percent: float | None
    beginning: str
    extent: str
    first_m: float
    farthest_m: float
    highest_m: float
    without_failsafe: str = ""

    @property
    def lines(self) -> tuple[str, ...]:
        """The briefing as text, a line each."""
        battery = "unknown" if self.battery_v is None else f"{self.battery_v:.1f} V"
        if self.battery_percent is not None:
            battery += f", {self.battery_percent:.0f} %"
        beginning = self.beginning.removeprefix("the ").capitalize()
        why = self.without_failsafe
        lost_link = (f"Lost link: the vehicle does not come home by itself ({why})",) if why else ()
        return (
            f"Vehicle: {self.vehicle}",
            f"Position: {self.lat_deg:.7f}, {self.lon_deg:.7f}",
            f"Battery: {battery}",
            f"{beginning}: {self.first_m:.0f} m away",
            f"Route: {self.extent}up to {self.farthest_m:.0f} m away and {self.highest_m:.0f} m above home",
            *lost_link,
        )


def check(  # noqa: PLR0913
    identity: Identity,
    mission: Mission,
    state: VehicleState,
    *,
    takeoff_altitude_m: float,
    max_distance_m: float = MAX_DISTANCE_M,
    areas: Sequence[FenceArea] = (),
    words: RouteWords | None = None,
    lands: bool = False,
) -> Briefing:
    """Refuse a vehicle or route that must not be flown; otherwise the briefing.

    Args:
        identity: What the vehicle is, with its fence parameters.
        mission: What would be uploaded, or the outline of what is followed.
        state: The vehicle's position, battery and mode now.
        takeoff_altitude_m: Metres above home.
        max_distance_m: How far from the vehicle the first waypoint may be, metres.
        areas: The polygons and circles of the vehicle's fence.
        words: What its places are called; those of a mission if None.
        lands: Whether the landing is waited for.

    Raises:
        VehicleError: The vehicle is no multicopter with ArduPilot, is armed, would not land, or is outside.
        MissionError: The route starts too far away, leaves the fence, or has an invalid waypoint.
    """
    words = words or MissionWords()
    _check_vehicle(identity, state)
    if lands:
        _check_rtl_lands(identity.parameters)
    for seq, item in mission.waypoints:
        _check_waypoint(words.place(seq), item)
    distances_m = _distances_m(mission, state)
    _check_distance(float(distances_m[0]), max_distance_m, words)
    _check_areas(areas, mission, state, words)
    heights_m, takeoff_m = _heights_m(mission), np.array([takeoff_altitude_m])
    _check_fence(identity.parameters, _Reach("the take-off", takeoff_m, "--takeoff-altitude"))
    _check_fence(identity.parameters, _Reach("the route", heights_m, "--altitude", distances_m))
    return _briefing(identity, state, distances_m, np.append(heights_m, takeoff_m), words)


def _briefing(
    identity: Identity, state: VehicleState, distances_m: Floats, heights_m: Floats, words: RouteWords
) -> Briefing:
    """``distances_m`` (n,) from the vehicle to each waypoint, ``heights_m`` (m,) above home."""
    return Briefing(
        vehicle=identity.name,
        lat_deg=state.lat_deg,
        lon_deg=state.lon_deg,
        battery_v=state.battery_v,
        battery_percent=state.battery_percent,
        beginning=words.beginning,
        extent=words.extent(len(distances_m)),
        first_m=float(distances_m[0]),
        farthest_m=float(distances_m.max()),
        highest_m=float(heights_m.max()),
        without_failsafe=identity.without_failsafe(words.mode),
    )


def check_kind(identity: Identity) -> None:
    """Refuse what is not a multicopter.

    Raises:
        VehicleError: It is something else.
    """
    if not identity.is_multicopter:
        raise VehicleError(f"{identity.name} is not a multicopter with ArduPilot; connect one")


def _check_vehicle(identity: Identity, state: VehicleState) -> None:
    check_kind(identity)
    if state.armed:
        raise VehicleError(
            f"the vehicle is already armed, in mode {state.mode}; land and disarm it, then start again"
        )


def _check_rtl_lands(parameters: Mapping[str, float]) -> None:
    for name in RTL_END_PARAMETERS:
        if parameters.get(name, 0.0) > 0:
            raise VehicleError(
                f"the vehicle would not land: {name} {parameters[name]:g} lets RTL end in the air; "
                "set it to 0, or leave out --land"
            )


def _check_distance(first_m: float, max_distance_m: float, words: RouteWords) -> None:
    if first_m > max_distance_m:
        raise MissionError(
            f"{words.beginning} is {first_m:.0f} m from the vehicle, more than {max_distance_m:.0f} m; "
            "move the vehicle closer, or allow more with --max-distance"
        )


def _check_waypoint(place: str, item: MissionItem) -> None:
    if item.frame not in _FLYABLE_FRAMES:
        raise MissionError(
            f"{place} has altitude frame {item.frame}, which ArduCopter does not support; "
            "use an altitude above home, above sea level or above terrain"
        )
    if not np.isfinite([item.lat_deg, item.lon_deg, item.alt_m]).all() or abs(item.lat_deg) > 90.0:
        raise MissionError(
            f"{place} has invalid coordinates: {item.lat_deg}, {item.lon_deg}, {item.alt_m} m; "
            "correct it, then start again"
        )
    if item.frame != Frame.ABSOLUTE and item.alt_m <= 0:
        raise MissionError(f"{place} is at {item.alt_m:g} m above home; fly higher with --altitude")


def _distances_m(mission: Mission, state: VehicleState) -> Floats:
    """Distance of each waypoint from the vehicle, metres: in a local frame other continents would be near."""
    places = [item for _, item in mission.waypoints]
    return distance_m(state.lat_deg, state.lon_deg, [p.lat_deg for p in places], [p.lon_deg for p in places])


def _check_areas(
    areas: Sequence[FenceArea], mission: Mission, state: VehicleState, words: RouteWords
) -> None:
    """Refuse straight legs, from the vehicle's position on, that leave the fence."""
    frame = LocalFrame(state.lat_deg, state.lon_deg)
    places = [
        (state.lat_deg, state.lon_deg),
        *((item.lat_deg, item.lon_deg) for _, item in mission.waypoints),
    ]
    waypoints_m = frame.to_metres(*np.array(places).T)
    here_m = waypoints_m[:1]
    for area in areas:
        if area.forbids_legs(here_m, here_m, frame).any():
            raise VehicleError("the vehicle stands outside its fence; move it inside, or change the fence")
        forbidden = np.flatnonzero(area.forbids_legs(waypoints_m[:-1], waypoints_m[1:], frame))
        if len(forbidden):
            raise MissionError(
                f"{words.way(mission.waypoints[forbidden[0]][0])} crosses the vehicle's fence; "
                "choose another part of the log, or change the fence"
            )


def _heights_m(mission: Mission) -> Floats:
    """Altitude of each waypoint above home, metres; above terrain counts as above home."""
    home_amsl_m = mission.home_item.alt_m
    return np.array(
        [item.alt_m - (home_amsl_m if item.frame == Frame.ABSOLUTE else 0.0) for _, item in mission.waypoints]
    )


@dataclass(frozen=True, slots=True)
class _Reach:
    """How high a part of a flight goes, and how far from the vehicle, m; ``option`` sets its heights."""

    what: str
    heights_m: Floats
    option: str
    distances_m: Floats = field(default_factory=lambda: np.zeros(1))


def _check_fence(parameters: Mapping[str, float], reach: _Reach) -> None:
    kinds = active_fence_types(parameters)
    margin_m = parameters.get("FENCE_MARGIN", 0.0)
    radius_m, high_m, low_m = reach.distances_m.max(), reach.heights_m.max(), reach.heights_m.min()
    lower, higher = f"fly lower with {reach.option}", f"fly higher with {reach.option}"
    bounds = (
        (
            FenceType.CIRCLE,
            "FENCE_RADIUS",
            "m from the vehicle",
            radius_m,
            1.0,
            "choose another part of the log",
        ),
        (FenceType.ALT_MAX, "FENCE_ALT_MAX", "m above home", high_m, 1.0, lower),
        (FenceType.ALT_MIN, "FENCE_ALT_MIN", "m above home", low_m, -1.0, higher),
    )
    for kind, name, unit, reach_m, outward, next_step in bounds:
        if kind in kinds and name in parameters and outward * (reach_m - parameters[name]) > -margin_m:
            raise MissionError(
                f"{reach.what} reaches {reach_m:.0f} {unit}, outside the vehicle's fence ({name} "
                f"{parameters[name]:g} m, margin {margin_m:g} m); {next_step}, or change the fence"
            )
