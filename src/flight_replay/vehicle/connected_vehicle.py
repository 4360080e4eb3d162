"""A connected vehicle: everything that the program requests of one."""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

from flight_replay.events import (
    Listener,
    Notice,
    Phase,
    PhaseStarted,
    Progress,
    VehicleState,
    Waiting,
    combine_listeners,
    ignore,
)
from flight_replay.exceptions import LinkFaultError, MissionError, PhaseTimeoutError, VehicleError
from flight_replay.flight_modes import mode_number
from flight_replay.logs.tlog.writer import Recorder
from flight_replay.mission.fence import FenceArea
from flight_replay.mission.items import Mission
from flight_replay.supervisor.vehicle_interface import Rebooted, Report, Target
from flight_replay.vehicle.dronekit_adapter import dronekit_vehicle
from flight_replay.vehicle.identity import Identity, find_vehicle, identify
from flight_replay.vehicle.link import timesync
from flight_replay.vehicle.link.connection_string import open_transport, silence_hint
from flight_replay.vehicle.link.discovery import DiscoveredVehicle, VehicleDiscovery
from flight_replay.vehicle.link.link import Link
from flight_replay.vehicle.link.signing import Signing, is_readable_by_others, read_key
from flight_replay.vehicle.link.vehicle_link import DroneKitLink
from flight_replay.vehicle.protocol.commands import CommandSender
from flight_replay.vehicle.protocol.mission_storage import NOT_REPLACED, MissionStorage
from flight_replay.vehicle.protocol.motion_targets import MotionTargets
from flight_replay.vehicle.protocol.parameters import (
    PutBack,
    limits_as_parameters,
    parameters_set,
    read_parameters,
    request_parameter,
    set_parameters,
    write_parameters,
)
from flight_replay.vehicle.protocol.stream_requests import StreamRequests
from flight_replay.vehicle.protocol.telemetry import Telemetry
from flight_replay.vehicle.stored_fence import stored_fence_areas

CONNECT_LIMIT_S = 30.0
_PROGRESS_S = 1.0
_NO_DATA_S = 30.0  # As long as a flight waits for a lost link.
_HEARTBEAT_AGE_S = 2.0  # An older one does not tell whether the vehicle is armed now.
_ARMED = "the vehicle is armed, in {}: {}; land and disarm it, then run this again"
_PARAMETERS_UNCHANGED = "its parameters are not changed"
_BOOT_S = 15.0  # Until a vehicle that reboots sends its clock again.
_REBOOTED = (
    "the autopilot rebooted during the upload, its mission may be incomplete; find out why, then start again"
)
_SPEEDUP = "SIM_SPEEDUP"
_UPLOAD_SPEEDUP = 4.0
_ROUND_TRIP_EVERY_S = 0.5
_KEY_WANTED = "the vehicle signs its messages and may ignore unsigned ones; give its key with --signing-key"
_TWO_VEHICLES = (
    "two vehicles with system id {} send to this port, from {} and {}; give one another system id "
    "(SYSID_THISMAV, in 4.7 MAV_SYSID) or another port; if it is one vehicle, heard by two ways, close one"
)
_ANOTHER_VEHICLE = (
    "another vehicle with system id {0} sends to this port, too: the one at {1} is flown, the one at {2} "
    "ignored; give it another system id before the next flight"
)
_UNBOUNDED_SPEEDUP = 100.0  # Assumed where SIM_SPEEDUP is 0 or less: as fast as possible.


class ConnectedVehicle:
    """A vehicle on an open link; implements ``supervisor.Vehicle``.

    ``identity`` is what it is, ``drone`` the ``dronekit.Vehicle``, ``link`` receives every frame.
    """

    def __init__(self, link: Link, vehicle: DiscoveredVehicle, listener: Listener = ignore) -> None:
        """``link`` is started, and ``vehicle`` was found on it; ``listener`` gets notices.

        Raises:
            VehicleError: Another vehicle has the same system id.
        """
        self.drone: Any = dronekit_vehicle(link, vehicle.system)
        self.link = link
        link.follow(vehicle.system, vehicle.component)
        self._vehicle_link = DroneKitLink(link, self.drone, vehicle.system, vehicle.component)
        self._commands = CommandSender(self._vehicle_link)
        self._telemetry = Telemetry(self.drone, self._commands)
        link.add_receiver(self._telemetry.receive, of_vehicle=True, needed=True)
        self._streams = StreamRequests(self._vehicle_link, self._telemetry)
        self._streams.renew(link.speedup)
        self.identity: Identity = identify(self._vehicle_link, vehicle)
        self._measured_s = float("-inf")
        self._targets = MotionTargets(self._vehicle_link, self.identity.version_numbers)
        link.add_receiver(self._targets.origin.receive, of_vehicle=True)
        self._storage = MissionStorage(
            self._vehicle_link, as_int=self.identity.takes_item_int, refuse_armed=self._refuse_armed
        )
        self._listener = combine_listeners(listener)
        self._arm_requested = self._told_of_another = self._told_of_fault = self._raised_fault = False
        self._check_is_only_one()

    def _check_is_only_one(self) -> None:
        """Refuse, before arming, two vehicles with one system id; in flight, tell of the other once."""
        both = self.link.both_senders
        if both is not None and not self._arm_requested:
            raise VehicleError(_TWO_VEHICLES.format(self.identity.system, *both))
        if both is not None and not self._told_of_another:
            self._told_of_another = True
            self._listener(Notice(_ANOTHER_VEHICLE.format(self.identity.system, *both), warning=True))

    def _check_faults(self) -> None:
        """Tell of the first fault of the program on the link, and once that nothing is heard for faults.

        Only once: RTL is commanded after that, and may be heard.
        """
        if self.link.faults.first and not self._told_of_fault:
            self._told_of_fault = True
            self._listener(Notice(self.link.faults.first, warning=True))
        try:
            self.link.faults.check()
        except LinkFaultError:
            if not self._raised_fault:
                self._raised_fault = True
                raise

    def reports(self, timeout_s: float) -> Sequence[Report]:
        """All reports since the last call, in order; waits up to the timeout for the first.

        Raises:
            VehicleError: Before arming was requested, another vehicle has the same system id.
            LinkFaultError: Once: an error of the program keeps it from hearing the vehicle.
        """
        self._check_is_only_one()
        self._check_faults()
        self._streams.renew(self.link.speedup)
        self._commands.retry_ping()
        return self._telemetry.reports(timeout_s)

    def request_mode(self, mode: str) -> None:
        """Request a flight mode of ArduCopter by its name."""
        self._commands.set_mode(mode_number(mode))

    def request_arm(self) -> None:
        """Request arming, with all pre-arm checks.

        Raises:
            VehicleError: Another vehicle has the same system id.
        """
        self._arm_requested = True  # It may be armed by an earlier request: reports go on, and so does RTL.
        if (both := self.link.both_senders) is not None:
            raise VehicleError(_TWO_VEHICLES.format(self.identity.system, *both))
        self._commands.arm()

    def request_takeoff(self, altitude_m: float) -> None:
        """Request a take-off to ``altitude_m`` above home."""
        self._commands.take_off(altitude_m)

    def request_prearm_checks(self) -> None:
        """Request the pre-arm checks; failures arrive as ``StatusText``."""
        self._commands.run_prearm_checks()

    def request_speed(self, speed_m_s: float) -> None:
        """Request a ground speed for flying to places in GUIDED."""
        self._commands.change_speed(speed_m_s)

    def request_position(self, lat_deg: float, lon_deg: float, alt_m: float) -> None:
        """Request to fly to a place in GUIDED, at a height above home."""
        self._targets.send_position(lat_deg, lon_deg, alt_m)

    def request_speedup(self, speedup: float) -> None:
        """Request another speed of a simulator's clock; nothing is waited for."""
        request_parameter(self._vehicle_link, _SPEEDUP, speedup)
        self.link.speedup = speedup

    @property
    def takes_targets(self) -> bool:
        """Whether the vehicle told where its local frame is."""
        return self._targets.origin.known

    def send_target(self, target: Target) -> None:
        """Send a target to follow until the next."""
        self._targets.send(target)

    def round_trip_s(self) -> float:
        """Wall-clock seconds from a message to the vehicle until its answer, measured again and again."""
        now_s = self._vehicle_link.now_s()
        if now_s - self._measured_s >= _ROUND_TRIP_EVERY_S:
            self._measured_s = now_s
            timesync.ping(self._vehicle_link)
        return self._vehicle_link.round_trip.from_freshest_s

    def _refuse_armed(self, consequence: str, max_age_s: float = math.inf, timeout_s: float = 0.0) -> None:
        """Refuse to change an armed vehicle, which may fly off at once by what is changed.

        Raises:
            VehicleError: It is armed, with what that means, or no heartbeat tells whether it is.
        """
        heartbeat = self._telemetry.heartbeat(max_age_s, timeout_s)
        if heartbeat is None:
            self.link.faults.check()
            raise VehicleError(
                f"link to the vehicle lost: no heartbeat for {timeout_s:.0f} s; check the link"
            )
        if heartbeat.armed:
            raise VehicleError(_ARMED.format(heartbeat.mode, consequence))

    def upload(self, mission: Mission, listener: Listener = ignore) -> None:
        """Upload a mission, download it and compare.

        Raises:
            MissionError: The vehicle refuses it.
            VehicleError: It is armed or reboots, the link fails, or the mission on board differs.
        """
        self._refuse_armed(NOT_REPLACED, _HEARTBEAT_AGE_S, _NO_DATA_S)
        total = len(mission.items)
        listener(PhaseStarted(Phase.UPLOAD, str(len(mission.waypoints))))
        try:
            with self._upload_speedup():
                self._storage.upload(mission, lambda done: listener(Progress("mission items", done, total)))
        except MissionError as error:
            if self._rebooted():
                raise VehicleError(_REBOOTED) from error
            raise

    def _rebooted(self) -> bool:
        """Whether the vehicle has rebooted: one that boots refuses what it does not support yet.

        Its clock tells, unless it goes on to tell where it is.
        """
        end_s = self._vehicle_link.now_s() + _BOOT_S
        kinds = {type(report) for report in self.reports(0.0)} - {VehicleState}
        while not kinds & {Rebooted, VehicleState} and self._vehicle_link.now_s() < end_s:
            kinds = {type(report) for report in self.reports(0.1)}
        return Rebooted in kinds

    @contextmanager
    def _upload_speedup(self) -> Iterator[None]:
        """Slow a fast simulator down: ArduPilot cancels an upload after 8 s of its time without an item."""
        fast = self.identity.simulated and self.link.speedup > _UPLOAD_SPEEDUP
        now = self.parameters([_SPEEDUP]) if fast else {}
        slowed = {name: _UPLOAD_SPEEDUP for name, speedup in now.items() if speedup > _UPLOAD_SPEEDUP}
        with self.parameters_set(slowed):
            yield

    def mission_verified(self, while_waiting: Callable[[], None] = lambda: None) -> bool:
        """Whether the mission on board is, item for item, the one that was uploaded.

        The download can take long: ``while_waiting`` is called repeatedly meanwhile, and an exception
        that it raises ends the download.

        Raises:
            VehicleError: The vehicle does not send it.
        """
        return self._storage.verified(while_waiting)

    def mission_on_board(self) -> Mission:
        """The mission on board, with the vehicle's home.

        Raises:
            VehicleError: The vehicle does not send it.
        """
        return self._storage.download()

    def fence_areas(self) -> tuple[FenceArea, ...]:
        """The polygons and circles of the vehicle's fence, if they are enabled; warns if they cannot be read.

        Raises:
            VehicleError: The vehicle does not send them, they are invalid, or need MAVLink 2.
        """
        return stored_fence_areas(self.link, self._vehicle_link, self.identity, self._listener)

    def wait_position(self, limit_s: float, listener: Listener = ignore) -> VehicleState:
        """The vehicle's next position, waiting up to ``limit_s`` of wall-clock time.

        Raises:
            PhaseTimeoutError: The vehicle has no position in time.
            VehicleError: The link is lost.
        """
        now_s = self._vehicle_link.now_s
        end_s, progress_s, received_s = now_s() + limit_s, now_s(), now_s()
        while now_s() < end_s:
            reports = self.reports(0.1)
            received_s = now_s() if reports else received_s
            states = [report for report in reports if isinstance(report, VehicleState)]
            if states:
                return states[-1]
            if now_s() - received_s > _NO_DATA_S:
                raise VehicleError(
                    f"link to the vehicle lost: no data for {_NO_DATA_S:.0f} s; check the link"
                )
            if now_s() - progress_s >= _PROGRESS_S:
                progress_s = now_s()
                listener(Waiting(Phase.PREARM, "no position yet"))
        raise PhaseTimeoutError(
            f"the vehicle has no position after {limit_s:.0f} s; give its GPS a clear view of the sky"
        )

    def parameters(self, names: Iterable[str]) -> dict[str, float]:
        """Values of those of the named parameters that the vehicle has, in its own units."""
        wanted = list(names)
        # A name that it is known to have, requested as well, soon shows which names it does not have.
        values = read_parameters(self._vehicle_link, [*wanted, *list(self.identity.parameters)[:1]])
        return {name: value for name, value in values.items() if name in wanted}

    def parameters_set(
        self, wanted: Mapping[str, float], put_back: PutBack = lambda unset: None
    ) -> AbstractContextManager[None]:
        """Set parameters, in the vehicle's own units, for as long as the context lasts.

        ``put_back`` is called after that, with why not for each that the vehicle did not confirm.

        Raises:
            VehicleError: The vehicle is armed.
        """
        if wanted:
            self._refuse_armed(_PARAMETERS_UNCHANGED, _HEARTBEAT_AGE_S, _NO_DATA_S)
        return parameters_set(self._vehicle_link, wanted, put_back)

    def set_speedup(self, speedup: float | None) -> None:
        """Run a simulated vehicle's clock ``speedup`` times as fast as wall-clock time.

        None leaves its speedup as it is, and only sends heartbeats often enough for it. ArduCopter
        3.3 keeps the speedup that it was started with.

        Raises:
            VehicleError: The vehicle does not accept the speedup.
        """
        now = self.parameters([_SPEEDUP]).get(_SPEEDUP)
        if speedup is None:
            speedup = 1.0 if now is None else now if 0.0 < now < _UNBOUNDED_SPEEDUP else _UNBOUNDED_SPEEDUP
        elif now not in (None, speedup):
            write_parameters(self._vehicle_link, {_SPEEDUP: speedup})
        self.link.speedup = speedup

    def set_known_parameters(self, wanted: Mapping[str, float]) -> dict[str, str]:
        """Set those of the parameters that the vehicle has, permanently, in its own units.

        Returns:
            Why not, for each that it did not confirm.

        Raises:
            VehicleError: The vehicle is armed.
        """
        self._refuse_armed(_PARAMETERS_UNCHANGED, _HEARTBEAT_AGE_S, _NO_DATA_S)
        return set_parameters(self._vehicle_link, wanted, list(self.identity.parameters)[:1])

    def limits_as_parameters(self, limits: Mapping[str, float]) -> dict[str, float]:
        """Parameters in the vehicle's own names and units, for fields of ``Limits`` in SI units."""
        return limits_as_parameters(self._vehicle_link, limits)


@contextmanager
def connect(  # noqa: PLR0913
    connection_string: str,
    *,
    baud: int = 57600,
    listener: Listener = ignore,
    speedup: float = 1.0,
    recorder: Recorder | None = None,
    signing_key: Path | None = None,
    limit_s: float = CONNECT_LIMIT_S,
) -> Iterator[ConnectedVehicle]:
    """Connect through DroneKit to the vehicle behind a connection string; closed on every way out.

    Args:
        connection_string: As for DroneKit: see ``link.transport``.
        baud: Baud rate of a serial port.
        listener: Gets the phases CONNECT and CLOSE, and a notice of each other vehicle on the link.
        speedup: How fast the vehicle's clock runs: heartbeats are sent often enough for it.
        recorder: Records every frame of both directions.
        signing_key: The file with the key of a vehicle that requires signed messages.
        limit_s: Seconds to wait for a heartbeat; infinite to try to connect without end too.

    Raises:
        VehicleError: The connection cannot be opened, no vehicle sends a heartbeat, or two have one id.
    """
    listener(PhaseStarted(Phase.CONNECT, connection_string))
    signing = _signing(signing_key, listener)
    transport = open_transport(connection_string, baud, keeps_trying=math.isinf(limit_s))
    link = Link(transport, speedup=speedup, recorder=recorder, signing=signing)
    try:
        link.start()
        hint = silence_hint(connection_string, baud)
        vehicle = _find(link, connection_string, hint, limit_s, listener)
        yield ConnectedVehicle(link, vehicle, listener)
    finally:
        try:
            listener(PhaseStarted(Phase.CLOSE))
        finally:
            link.close()


def _find(
    link: Link, connection_string: str, hint: str, limit_s: float, listener: Listener
) -> DiscoveredVehicle:
    """The vehicle on a link; notices of other vehicles, and of signed messages that cannot be checked.

    Raises:
        VehicleError: No vehicle sends a heartbeat, or none that is signed with the key.
    """
    discovery = VehicleDiscovery(link.faults.check)
    link.add_receiver(discovery.receive, needed=True)
    try:
        vehicle = find_vehicle(discovery, connection_string, hint, limit_s, listener)
    except VehicleError as error:
        if link.ignored:
            raise VehicleError(
                f"what is sent on {connection_string} is not signed with the key of --signing-key; "
                "check the key, and that the vehicle signs"
            ) from error
        raise
    if link.received_signed and not link.signs:
        listener(Notice(_KEY_WANTED, warning=True))
    for other in discovery.vehicles[1:]:
        listener(Notice(f"vehicle {other.system} is also on this link; it is ignored", warning=True))
    link.remove_receiver(discovery.receive)
    return vehicle


def _signing(key_file: Path | None, listener: Listener) -> Signing | None:
    """Signing with the key in a file; warns of one that others can read."""
    if key_file is None:
        return None
    key = read_key(key_file)
    if is_readable_by_others(key_file):
        run = shlex.join(["chmod", "600", str(key_file)])
        listener(Notice(f"other users can read the signing key {key_file}; run: {run}", warning=True))
    return Signing(key)
