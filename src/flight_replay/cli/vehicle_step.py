"""The step before the flight that gets a vehicle: a simulator or ``--connect``, and its limits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING

from flight_replay.cli.options import Options
from flight_replay.events import Listener, Notice
from flight_replay.exceptions import VehicleError
from flight_replay.mission.items import Home
from flight_replay.planning.vehicle_limits import FOLLOWING_NAMES, PARAMETER_NAMES, VehicleLimits, limits_of

if TYPE_CHECKING:
    from flight_replay.logs.tlog.writer import Recorder
    from flight_replay.vehicle import ConnectedVehicle

_TURN_RATE = "ATC_SLEW_YAW"
_DRAG_UNKNOWN = (
    " The vehicle does not tell its drag (EK3_DRAG_BCOEF_X, _Y, EK3_DRAG_MCOEF); planned with that of SITL's "
    "quadcopter, about 4 m/s² at 8 m/s. With more of it, follow slower, such as with --speed 0.5x."
)


@contextmanager
def recording(options: Options) -> Iterator[Recorder | None]:
    """The recorder of ``--record``."""
    if options.record is None:
        yield None
        return
    from flight_replay.logs.tlog.writer import Recorder

    with Recorder(options.record) as recorder:
        yield recorder


@contextmanager
def vehicle_or_simulator(options: Options, home: Home, listener: Listener) -> Iterator[str]:
    """The connection string of ``--connect``, or of a simulator that starts where the recording did."""
    if options.connect is not None:
        yield options.connect
        return
    from flight_replay.simulator.autopilot.location import Start
    from flight_replay.vehicle.sitl import simulator

    start = Start(home.lat_deg, home.lon_deg, home.alt_amsl_m or 0.0)
    speedup = options.speedup or 1.0
    with simulator(options.sim, options.sitl, start, speedup=speedup, listener=listener) as connection:
        yield connection


@contextmanager
def connected_vehicle(
    connection: str, options: Options, listener: Listener, recorder: Recorder | None
) -> Iterator[ConnectedVehicle]:
    """The vehicle behind a connection string, with the ground stations of ``--gcs`` on the same link.

    Raises:
        VehicleError: No vehicle is there, it cannot fly what is planned, or it is a real one and the
            options are for simulated ones.
    """
    from flight_replay import vehicle
    from flight_replay.vehicle.link.ground_stations import ground_stations

    with (
        vehicle.connect(
            connection,
            baud=options.baud,
            listener=listener,
            speedup=options.speedup or 1.0,
            recorder=recorder,
            signing_key=options.signing_key,
            limit_s=math.inf if options.wait else vehicle.CONNECT_LIMIT_S,
        ) as connected,
        ground_stations(connected.link, options.gcs, allow_open=options.gcs_open),
    ):
        _check_options(connected, options)
        if connected.identity.simulated and not options.dry_run:
            connected.set_speedup(options.speedup)
        yield connected


def _check_options(connected: ConnectedVehicle, options: Options) -> None:
    """Refuse a vehicle that cannot fly, before a fit of minutes, and options for simulated ones."""
    from flight_replay.vehicle.preflight import check_kind

    if not options.dry_run:
        check_kind(connected.identity)
    if connected.identity.simulated:
        return
    if options.speedup not in (None, 1.0):
        raise VehicleError(f"{connected.identity.name} is a real vehicle; leave out --speedup")
    if options.passes > 1:
        raise VehicleError(f"{connected.identity.name} is a real vehicle; leave out --passes")
    if options.limits == "recorded":
        raise VehicleError(f"{connected.identity.name} is a real vehicle; leave out --limits recorded")


def vehicle_limits(connected: ConnectedVehicle, options: Options, listener: Listener) -> VehicleLimits:
    """The limits of a vehicle; the defaults, with a warning, where it does not tell them."""
    names = FOLLOWING_NAMES if options.mode == "guided" else PARAMETER_NAMES
    parameters: Mapping[str, float] = connected.parameters(names)
    if options.mode == "guided":
        parameters = _as_followed(connected, parameters)
    identity = connected.identity
    limits = limits_of(parameters, identity.name, (*identity.version_numbers, identity.maturity))
    if limits is None:
        listener(
            Notice(
                "the vehicle does not send its speed limits; the plan is for the defaults of ArduCopter 4.6",
                warning=True,
            )
        )
    limits = limits or VehicleLimits()
    if options.mode == "guided" and limits.drag is None and not connected.identity.simulated:
        listener(Notice(_DRAG_UNKNOWN))
    return limits


def _as_followed(connected: ConnectedVehicle, parameters: Mapping[str, float]) -> Mapping[str, float]:
    """Parameters with the turn rate that is raised while following."""
    from flight_replay.vehicle.following import raised_for_following

    raised = raised_for_following(connected.identity).get(_TURN_RATE, 0.0)
    if parameters.get(_TURN_RATE, raised) >= raised:
        return parameters
    return {**parameters, _TURN_RATE: raised}
