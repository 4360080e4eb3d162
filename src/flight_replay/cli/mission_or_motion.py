"""What differs between a route that is flown as a mission in AUTO and one that is followed in GUIDED."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from flight_replay.cli.options import Options
from flight_replay.events import Listener, Notice
from flight_replay.exceptions import MissionError
from flight_replay.geometry.reference_motion import ReferenceMotion
from flight_replay.output.json_summary import reference_summary
from flight_replay.planning.route import Route
from flight_replay.supervisor import FollowPlan, Plan

if TYPE_CHECKING:
    from flight_replay.vehicle import ConnectedVehicle
    from flight_replay.vehicle.identity import Identity
    from flight_replay.vehicle.route_words import RouteWords


class FlownAs(Protocol):
    """How a route is flown."""

    @property
    def words(self) -> RouteWords:
        """What its places are called."""

    def briefing_lines(self) -> Sequence[str]:
        """What else a person has to know before a real vehicle is armed.

        Raises:
            MissionError: A real vehicle must not fly it.
        """

    def prepare(
        self, connected: ConnectedVehicle, connection: str, stack: ExitStack, listener: Listener
    ) -> None:
        """Get the vehicle ready before it is armed; ``stack`` undoes what is not to last.

        Raises:
            FlightReplayError: The vehicle does not accept what it needs.
        """

    def plan(self, identity: Identity) -> Plan | FollowPlan:
        """What the supervisor flies."""


def flown_as(options: Options, route: Route) -> FlownAs:
    """How a route is flown: as a mission, or, where it has a reference, by following that."""
    if route.reference is None:
        return AsMission(options, route)
    return AsMotion(options, route, route.reference)


class AsMission:
    """A mission, uploaded and flown in AUTO."""

    def __init__(self, options: Options, route: Route) -> None:
        self._options, self._route = options, route

    @property
    def words(self) -> RouteWords:
        """Its waypoints."""
        from flight_replay.vehicle.route_words import MissionWords

        return MissionWords()

    def briefing_lines(self) -> Sequence[str]:
        """Nothing but what the preflight check tells."""
        return ()

    def prepare(
        self, connected: ConnectedVehicle, connection: str, stack: ExitStack, listener: Listener
    ) -> None:
        """Upload the mission, with limits raised for the flight; that on board is saved before."""
        if self._options.connect is not None:
            self._save_mission_on_board(connected, connection, listener)
        if self._route.required_limits:
            wanted = _raised(connected, self._route.required_limits)
            stack.enter_context(_changed(self._options, wanted, connected, connection, listener))
        connected.upload(self._route.mission, listener)

    def _save_mission_on_board(
        self, connected: ConnectedVehicle, connection: str, listener: Listener
    ) -> None:
        """Save the mission on board, and show the command that restores it."""
        from flight_replay.cli.restore import save_mission_on_board

        path = save_mission_on_board(connected, Path.cwd(), datetime.now())
        if path is not None:
            command = restore_commands(self._options, connection)(path)
            listener(
                Notice(
                    f"Saved the mission on board to {path}. To restore it after the flight, run: {command}"
                )
            )

    def plan(self, identity: Identity) -> Plan:
        """The mission, for so long."""
        return Plan(
            mission=self._route.mission,
            duration_s=self._options.duration_s,
            takeoff_altitude_m=self._options.takeoff_altitude_m,
            land=self._options.land,
            rtl_loiter_s=identity.rtl_loiter_s,
            rally_limit_m=identity.rally_limit_m,
        )


def _raised(connected: ConnectedVehicle, limits: Mapping[str, float]) -> Mapping[str, float]:
    """The vehicle's parameters for ``limits`` that are lower than those."""
    wanted = connected.limits_as_parameters(limits)
    current = connected.parameters(wanted)
    return {name: value for name, value in wanted.items() if value > current[name]}


def _changed(
    options: Options,
    wanted: Mapping[str, float],
    connected: ConnectedVehicle,
    connection: str,
    listener: Listener,
) -> AbstractContextManager[None]:
    """Change parameters for the flight; those of a simulator that was started for it are not kept."""
    if options.connect is None:
        return connected.parameters_set(wanted)
    from flight_replay.cli.kept_parameters import kept_parameters

    command = restore_commands(options, connection)
    return kept_parameters(connected, wanted, Path.cwd(), command, listener)


def restore_commands(options: Options, connection: str) -> Callable[[Path], str]:
    """What gives the shell command that restores a file on the vehicle that the options name."""
    from flight_replay.cli.restore import restore_command

    return lambda path: restore_command(path, connection, options.baud, options.signing_key)


class AsMotion:
    """A motion, followed in GUIDED."""

    def __init__(self, options: Options, route: Route, reference: ReferenceMotion) -> None:
        self._options, self._route, self._reference = options, route, reference

    @property
    def words(self) -> RouteWords:
        """Its times."""
        from flight_replay.planning.following.followed_route import OUTLINE_STEP_S
        from flight_replay.vehicle.route_words import MotionWords

        return MotionWords(self._reference.times_s(OUTLINE_STEP_S))

    def briefing_lines(self) -> Sequence[str]:
        """How fast, hard and low it flies; faster than a real vehicle's own speed setting is refused."""
        motion, allowed_m_s = reference_summary(self._reference), self._route.limits.limits.wp_speed_m_s
        if motion["top_speed_m_s"] > allowed_m_s:
            raise MissionError(
                f"the recording reaches {motion['top_speed_m_s']:.1f} m/s, more than the vehicle's own speed "
                f"setting of {allowed_m_s:g} m/s; fly it slower, such as with --speed 0.5x"
            )
        return [
            f"Motion: up to {motion['top_speed_m_s']:.1f} m/s and "
            f"{motion['top_acceleration_m_s2']:.1f} m/s², "
            f"never below {motion['lowest_m']:.0f} m above home"
        ]

    def prepare(
        self, connected: ConnectedVehicle, connection: str, stack: ExitStack, listener: Listener
    ) -> None:
        """Nothing is uploaded, but the vehicle is to brake soon when targets stop coming."""
        from flight_replay.vehicle.following import parameters_for_following

        wanted = parameters_for_following(connected)
        stack.enter_context(_changed(self._options, wanted, connected, connection, listener))

    def plan(self, identity: Identity) -> FollowPlan:
        """The motion, for so much of the recording."""
        from flight_replay.planning.following.braking import braking_within
        from flight_replay.planning.following.followed_route import reference_for
        from flight_replay.vehicle.following import tuning_of

        options, route = self._options, self._route
        tuning = braking_within(tuning_of(identity), route.limits.limits)
        return FollowPlan(
            reference=reference_for(self._reference, route, tuning),
            recorded_s=float(route.wanted.time_s[-1]),
            duration_s=None if options.duration_s is None else options.duration_s / options.pace,
            max_error_m=options.max_error_m,
            tuning=tuning,
            approach_m_s=options.speed_m_s if isinstance(options.speed_m_s, float) else None,
            speed_m_s=route.limits.limits.wp_speed_m_s,
            speedup=options.speedup if options.connect is None else None,
            passes=options.passes,
            takeoff_altitude_m=options.takeoff_altitude_m,
            land=options.land,
            rtl_loiter_s=identity.rtl_loiter_s,
            rally_limit_m=identity.rally_limit_m,
        )
