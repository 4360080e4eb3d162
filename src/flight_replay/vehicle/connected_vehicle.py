"""A connected vehicle: everything that the program asks of one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from typing import Any

from flight_replay.errors import PhaseTimeoutError, VehicleError
from flight_replay.events import (
    Listener,
    Notice,
    Phase,
    PhaseStarted,
    Progress,
    VehicleState,
    Waiting,
    ignore,
)
from flight_replay.flight_modes import mode_number
from flight_replay.logs.tlog.writer import Recorder
from flight_replay.mission.fence import FenceArea, active_fence_types, areas_from_items
from flight_replay.mission.items import Mission
from flight_replay.supervisor.vehicle_interface import Report
from flight_replay.vehicle.dronekit_adapter import dronekit_vehicle
from flight_replay.vehicle.identity import Identity, find_vehicle, identify
from flight_replay.vehicle.link.connection_string import opened
from flight_replay.vehicle.link.discovery import Sighting, Sightings
from flight_replay.vehicle.link.link import Link
from flight_replay.vehicle.link.port import LinkPort
from flight_replay.vehicle.protocol.commands import Commands
from flight_replay.vehicle.protocol.mission_download import FENCE, Reader
from flight_replay.vehicle.protocol.mission_storage import OnBoard
from flight_replay.vehicle.protocol.parameters import (
    limits_as_parameters,
    parameters_set,
    read_parameters,
    write_parameters,
)
from flight_replay.vehicle.protocol.stream_requests import Streams
from flight_replay.vehicle.protocol.telemetry import Telemetry

CONNECT_LIMIT_S = 30.0
_TELL_S = 1.0
_SILENT_S = 30.0  # As long as a flight waits for a link that was lost.
_SPEEDUP = "SIM_SPEEDUP"
_POLYGONS = 4  # The bit of FENCE_TYPE for areas on the map (AC_Fence.h).
_UPLOAD_SPEEDUP = 4.0
_UNBOUNDED_SPEEDUP = 100.0  # ArduPilot takes 0 and less for "as fast as it goes".


class ConnectedVehicle:
    """A vehicle on an open link; fulfils ``supervisor.Vehicle``.

    ``identity`` says what it is, ``drone`` is DroneKit's view of it, ``link`` carries every frame.
    """

    def __init__(self, link: Link, sighting: Sighting) -> None:
        """Talk to the vehicle that was sighted on a link that runs."""
        self.drone: Any = dronekit_vehicle(link, sighting.system, sighting.component)
        self.link = link
        self._port = LinkPort(link, self.drone, sighting.system, sighting.component)
        self._commands = Commands(self._port)
        self._telemetry = Telemetry(sighting.system, sighting.component, self.drone, self._commands)
        link.add_receiver(self._telemetry.receive)
        self._streams = Streams(self._port, self._telemetry)
        self._streams.keep(link.speedup)
        self.identity: Identity = identify(self._port, sighting)
        self._on_board = OnBoard(self._port, as_int=self.identity.takes_item_int)

    def reports(self, timeout_s: float) -> Sequence[Report]:
        """Everything reported since the last call, in order; waits for the first until the timeout."""
        self._streams.keep(self.link.speedup)
        self._commands.keep()
        return self._telemetry.take(timeout_s)

    def request_mode(self, mode: str) -> None:
        """Ask for a flight mode by ArduCopter's name of it."""
        self._commands.set_mode(mode_number(mode))

    def request_arm(self) -> None:
        """Ask to arm, with all of the vehicle's own checks."""
        self._commands.arm()

    def request_takeoff(self, altitude_m: float) -> None:
        """Ask to climb to ``altitude_m`` above home."""
        self._commands.take_off(altitude_m)

    def request_prearm_checks(self) -> None:
        """Ask for the reasons against arming."""
        self._commands.report_prearm()

    def upload(self, mission: Mission, listener: Listener = ignore) -> None:
        """Put a mission on board, read it back and compare.

        Raises:
            MissionError: The vehicle refuses it.
            VehicleError: The link fails, or what is on board is not what was sent.
        """
        total = len(mission.items)
        listener(PhaseStarted(Phase.UPLOAD, str(len(mission.waypoints))))
        with self._unhurried():
            self._on_board.put(mission, lambda done: listener(Progress("mission items", done, total)))

    @contextmanager
    def _unhurried(self) -> Iterator[None]:
        """Slow a simulator down: ArduPilot cancels an upload that is silent for 8 s of *its* time."""
        fast = self.identity.simulated and self.link.speedup > _UPLOAD_SPEEDUP
        there = self.parameters([_SPEEDUP]) if fast else {}
        slowed = {name: _UPLOAD_SPEEDUP for name, now in there.items() if now > _UPLOAD_SPEEDUP}
        with self.parameters_set(slowed):
            yield

    def mission_verified(self, while_waiting: Callable[[], None] = lambda: None) -> bool:
        """Whether the mission on board is, item for item, the one that was uploaded.

        The download can take long: ``while_waiting`` is called repeatedly meanwhile, and an exception
        that it raises ends the download.

        Raises:
            VehicleError: The vehicle does not tell.
        """
        return self._on_board.verified(while_waiting)

    def mission_on_board(self) -> Mission:
        """The mission that is on board now, under the vehicle's home.

        Raises:
            VehicleError: The vehicle does not tell.
        """
        return self._on_board.read()

    def fence_areas(self) -> tuple[FenceArea, ...]:
        """The polygons and circles of the vehicle's fence, if they are switched on.

        Raises:
            VehicleError: The vehicle does not tell them, or they cannot be understood.
        """
        if not active_fence_types(self.identity.parameters) & _POLYGONS:
            return ()
        if not self.identity.takes_item_int:
            return ()  # Firmware that old keeps its fence in another way, and no circles.
        return areas_from_items(Reader(self._port, as_int=True, mission_type=FENCE).read())

    def wait_position(self, limit_s: float, listener: Listener = ignore) -> VehicleState:
        """Where the vehicle is now, waiting until it knows: seconds here.

        Raises:
            PhaseTimeoutError: It does not know in time.
            VehicleError: It is not heard any more.
        """
        now_s = self._port.now_s
        end_s, tell_s, heard_s = now_s() + limit_s, now_s(), now_s()
        while now_s() < end_s:
            told = self.reports(0.1)
            heard_s = now_s() if told else heard_s
            states = [news for news in told if isinstance(news, VehicleState)]
            if states:
                return states[-1]
            if now_s() - heard_s > _SILENT_S:
                raise VehicleError(
                    f"nothing was heard from the vehicle for {_SILENT_S:.0f} s; check the link"
                )
            if now_s() - tell_s >= _TELL_S:
                tell_s = now_s()
                listener(Waiting(Phase.PREARM, "no position yet"))
        raise PhaseTimeoutError(
            f"the vehicle does not know where it is after {limit_s:.0f} s; give its GPS a view of the sky"
        )

    def parameters(self, names: Iterable[str]) -> dict[str, float]:
        """Values of those of the named parameters that the vehicle has, in its own units."""
        wanted = list(names)
        # Asked together with one that it is known to have, a name that it lacks is soon known to be one.
        values = read_parameters(self._port, [*wanted, *list(self.identity.parameters)[:1]])
        return {name: value for name, value in values.items() if name in wanted}

    def parameters_set(self, wanted: Mapping[str, float]) -> AbstractContextManager[None]:
        """Set parameters, in the vehicle's own units, for as long as the context lasts."""
        return parameters_set(self._port, wanted)

    def run_at(self, speedup: float | None) -> None:
        """Make a simulated vehicle's clock run ``speedup`` times as fast as ours, if it does not yet.

        None leaves its speed as it is, and keeps pace with it. ArduCopter 3.3 cannot be told any more:
        there the option that it was started with stands.

        Raises:
            VehicleError: It does not take the speed.
        """
        told = self.parameters([_SPEEDUP]).get(_SPEEDUP)
        if speedup is None:
            speedup = 1.0 if told is None else told if 0.0 < told < _UNBOUNDED_SPEEDUP else _UNBOUNDED_SPEEDUP
        elif told not in (None, speedup):
            write_parameters(self._port, {_SPEEDUP: speedup})
        self.link.speedup = speedup

    def set_known_parameters(self, wanted: Mapping[str, float]) -> None:
        """Set those of the parameters that the vehicle has, for good, in its own units.

        Raises:
            VehicleError: It does not take one of them.
        """
        known = read_parameters(self._port, wanted)
        write_parameters(self._port, {name: wanted[name] for name in known})

    def limits_as_parameters(self, limits: Mapping[str, float]) -> dict[str, float]:
        """Parameters in the vehicle's naming scheme for fields of ``simulator.limits.Limits``, SI units."""
        return limits_as_parameters(self._port, limits)


@contextmanager
def connect(  # noqa: PLR0913
    connection_string: str,
    *,
    baud: int = 57600,
    listener: Listener = ignore,
    speedup: float = 1.0,
    recorder: Recorder | None = None,
    limit_s: float = CONNECT_LIMIT_S,
) -> Iterator[ConnectedVehicle]:
    """Connect through DroneKit to the vehicle behind a connection string, and close on every way out.

    Args:
        connection_string: As DroneKit takes it: see ``transport``.
        baud: Speed of a serial port.
        listener: Hears the phases CONNECT and CLOSE, and of neighbours on the link.
        speedup: How fast the vehicle's clock runs, for heartbeats often enough by it.
        recorder: Keeps every frame of both directions.
        limit_s: Seconds to wait for a vehicle.

    Raises:
        VehicleError: The connection cannot be opened, or no vehicle is heard.
    """
    listener(PhaseStarted(Phase.CONNECT, connection_string))
    link = Link(opened(connection_string, baud), speedup=speedup, recorder=recorder)
    try:
        sightings = Sightings()
        link.add_receiver(sightings.receive)
        link.start()
        sighting = find_vehicle(sightings, connection_string, limit_s)
        for other in sightings.vehicles[1:]:
            listener(Notice(f"vehicle {other.system} is on this link too and is left alone", warning=True))
        yield ConnectedVehicle(link, sighting)
    finally:
        try:
            listener(PhaseStarted(Phase.CLOSE))
        finally:
            link.close()
