"""The legs of a predicted flight: where the nose points by itself, and where the recorded one pointed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.matching import match_in_order
from flight_replay.geometry.movement import Movement
from flight_replay.geometry.polyline import lengths_along_m
from flight_replay.mission.items import Mission
from flight_replay.planning.prediction import step_for_s
from flight_replay.planning.route import Route
from flight_replay.simulator.flight.trajectory import Trajectory, home_frame, simulate

SAMPLE_S = 0.1
"""A turn at ArduCopter's highest rate, 60 degrees a second, is 6 degrees further in that time."""
_SAMPLES_A_PLACE = 5
_PIECE_M = 0.25


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """A leg in n samples, from when the mission item that flies it starts until the next one starts.

    ``time_s`` (n,) counts from its beginning. ``wanted_deg`` (n,), without jumps from 360 to 0, is the
    recorded heading, not a number where that is unknown; ``own_deg`` (n,) is where the vehicle turns to
    without an item, not a number where it is so slow that it does not turn. ``north_east_m`` (n, 2) is
    where it is, ``has_items`` whether other DO items start with the leg.
    """

    time_s: Floats
    wanted_deg: Floats
    own_deg: Floats
    north_east_m: Floats
    has_items: bool = False

    @property
    def duration_s(self) -> float:
        """How long it lasts."""
        return float(self.time_s[-1])


@dataclass(frozen=True, slots=True, eq=False)
class PredictedFlight:
    """A mission as the model of ArduCopter flies it, in n samples from where AUTO begins.

    ``begin_s`` is when the legs to its waypoints begin, and when the last one ends; ``heading_deg`` (n,) has
    no jumps, ``own_deg`` (n,) is as in ``Leg``.
    """

    time_s: Floats
    begin_s: Floats
    north_east_m: Floats
    heading_deg: Floats
    own_deg: Floats

    @classmethod
    def of(cls, route: Route, takeoff_m: float) -> PredictedFlight:
        """Fly the mission of a route with at least one waypoint; positions are metres in the route's frame.

        Args:
            route: what to fly.
            takeoff_m: take-off altitude above home: a climb from there makes the first leg begin slowly.

        Raises:
            MissionError: the model cannot fly it.
        """
        mission, step_s = route.mission, step_for_s(route)
        flight = simulate(mission, route.limits.limits, start_m=(0.0, 0.0, takeoff_m), step_s=step_s)
        begin_s = np.array(list(_begins_s(mission, flight)))
        sample_s = np.arange(begin_s[0], begin_s[-1] + SAMPLE_S, SAMPLE_S)
        columns = flight.north_m, flight.east_m, np.unwrap(flight.heading_deg, period=360.0)
        north, east, heading = (np.interp(sample_s, flight.time_s, column) for column in columns)
        ground_m = route.frame.to_metres(*home_frame(mission).to_degrees(np.column_stack([north, east])))
        steps = np.minimum(np.searchsorted(flight.time_s, sample_s), len(flight.time_s) - 1)
        return cls(sample_s, begin_s, ground_m, heading, flight.course_deg[steps])

    def wanted_deg(self, recorded: Movement, *, timed: bool) -> Floats:
        """The recorded headings (n,) without jumps, not a number between fixes that have none.

        Args:
            recorded: at least one fix, its times counting from when the vehicle is at the first waypoint.
            timed: whether the heading at equal times is wanted; else it is that of the recorded place
                that the vehicle passes.
        """
        times_s = self.time_s - self.begin_s[1] if timed else self._passing_s(recorded)
        known = np.isfinite(recorded.heading_deg)
        turned = np.unwrap(recorded.heading_deg[known], period=360.0)
        share = np.interp(times_s, recorded.time_s, known.astype(float))
        return np.where(share > 0.5, np.interp(times_s, recorded.time_s[known], turned), np.nan)

    def _passing_s(self, recorded: Movement) -> Floats:
        """When the recording passed (n,) where the vehicle is at each sample."""
        some = slice(None, None, _SAMPLES_A_PLACE)
        along_m = match_in_order(self.north_east_m[some], recorded.north_east_m, _PIECE_M).along_m
        passing_s = np.interp(along_m, lengths_along_m(recorded.north_east_m), recorded.time_s)
        return np.interp(self.time_s, self.time_s[some], passing_s)


def _begins_s(mission: Mission, flight: Trajectory) -> Iterator[float]:
    last_s = flight.auto_s[0]
    yield last_s
    for seq, _ in mission.waypoints:
        last_s = max(flight.reached_s.get(seq, last_s), last_s)
        yield last_s


def legs_of(mission: Mission, flight: PredictedFlight, wanted_deg: Floats) -> list[Leg]:
    """The legs to all waypoints, in order.

    Args:
        mission: without items that turn the vehicle.
        flight: how it is flown, with such items or without.
        wanted_deg: the headings wanted at its samples (n,).
    """
    at = np.searchsorted(flight.time_s, flight.begin_s)
    return [
        Leg(
            flight.time_s[span] - flight.time_s[at[k]],
            wanted_deg[span],
            flight.own_deg[span],
            flight.north_east_m[span],
            has_items,
        )
        for k, has_items in enumerate(_items_before(mission))
        for span in [slice(at[k], at[k + 1] + 1)]
    ]


def _items_before(mission: Mission) -> Iterator[bool]:
    """Whether DO items start with the leg to each waypoint."""
    has_items = False
    for item in mission.items:
        if item.is_waypoint:
            yield has_items
        has_items = not item.is_waypoint
