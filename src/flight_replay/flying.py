"""The steps in the air: a vehicle or a simulator, the mission on board, the flight, and home."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

from flight_replay.console import Console
from flight_replay.events import Finished, Listener
from flight_replay.options import Options
from flight_replay.outcome import Outcome, compare_flight
from flight_replay.route import Route
from flight_replay.supervisor import FlightRecord, Plan
from flight_replay.supervisor import fly as supervise
from flight_replay.track import Track


@dataclass(frozen=True, slots=True, eq=False)
class Flown:
    """A flight and what flew it."""

    vehicle: str
    simulated: bool
    record: FlightRecord
    outcome: Outcome


class WallClock:
    """Times silences, whatever the vehicle's clock does."""

    def monotonic_s(self) -> float:
        """Seconds that never run backwards."""
        return time.monotonic()


def fly(options: Options, route: Route, console: Console, listener: Listener) -> Flown:
    """Fly the route as the options say.

    Raises:
        FlightReplayError: Nothing flew, or the flight ended before the mission began.
    """
    from flight_replay import vehicle

    with ExitStack() as stack:
        recorder = None
        connection = options.connect or stack.enter_context(_simulator(options, route.covered))
        connected = stack.enter_context(
            vehicle.connect(
                connection, baud=options.baud, listener=listener, speedup=options.speedup, recorder=recorder
            )
        )
        connected.upload(route.mission, listener)
        plan = Plan(
            mission=route.mission,
            duration_s=options.duration_s,
            takeoff_altitude_m=options.takeoff_altitude_m,
            land=options.land,
        )
        record = supervise(connected, WallClock(), plan, listener)
        identity = connected.identity
    listener(Finished(record.ended))
    return Flown(identity.name, identity.simulated, record, compare_flight(route, record))


@contextmanager
def _simulator(options: Options, recorded: Track) -> Iterator[str]:
    """A simulator that starts where the recording did; its connection string."""
    from flight_replay.simulator import launch
    from flight_replay.simulator.place import Start

    ground_m = float(recorded.amsl_m[0] - recorded.alt_m[0])
    start = Start(float(recorded.lat_deg[0]), float(recorded.lon_deg[0]), ground_m)
    with launch.run(start, speedup=options.speedup) as running:
        yield running.connection
