"""A vehicle behind a connection string: found, identified, commanded, and disconnected."""

from __future__ import annotations

import math
import queue
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from flight_replay.events import Event, Notice, Phase, PhaseStarted, Progress, VehicleState, Waiting
from flight_replay.exceptions import FlightReplayError, MissionError, PhaseTimeoutError, VehicleError
from flight_replay.mavlink import dialect
from flight_replay.mission.items import Mission
from flight_replay.simulator.autopilot.faults import SECOND_COPTER, Faults, Firmware, old_copter
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.server import launch
from flight_replay.supervisor.vehicle_interface import Heartbeat, Rebooted, Report
from flight_replay.vehicle import ConnectedVehicle, connect
from flight_replay.vehicle import connected_vehicle as module
from tests.helpers.armed import wait_armed
from tests.helpers.fault_link import fault_link
from tests.helpers.fault_runs import ROUTE
from tests.helpers.machine import free_udp_port

START = Start(47.397742, 8.545594, 488.0)


@contextmanager
def copter(
    faults: Faults | None = None,
    *,
    listen: str = "tcp:127.0.0.1:0",
    speedup: float = 20.0,
    events: list[Event] | None = None,
) -> Iterator[ConnectedVehicle]:
    with launch.run(START, speedup=speedup, faults=faults, listen=(listen,)) as running:
        ours = {"tcp": "tcp", "udpout": "udpin", "udpin": "udpout"}
        kind, address = running.connection.split(":", 1)
        connection = f"{ours[kind]}:{address}"
        listener = (events if events is not None else []).append
        with connect(connection, speedup=speedup, listener=listener, limit_s=60.0) as connected:
            yield connected


@pytest.mark.parametrize("kind", ["tcp", "udpout", "udpin"])
def test_a_vehicle_is_found_over_any_transport(kind: str) -> None:
    """TCP, UDP that listens, and UDP that sends first."""
    port = 0 if kind == "tcp" else free_udp_port()
    with copter(listen=f"{kind}:127.0.0.1:{port}") as vehicle:
        assert vehicle.identity.name == "built-in copter, flies as ArduCopter 4.6 (system 1)"
        assert vehicle.identity.takes_item_int
        vehicle.upload(ROUTE)
        assert vehicle.mission_verified()


def test_a_stranger_is_sent_nothing_once_the_vehicle_is_known() -> None:
    """However often it sends; the mission goes to the vehicle alone."""
    port = free_udp_port()
    with (
        copter(listen=f"udpout:127.0.0.1:{port}") as vehicle,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger,
    ):
        stranger.setblocking(False)
        stranger.sendto(b"x", ("127.0.0.1", port))
        vehicle.upload(ROUTE)
        stranger.sendto(b"x", ("127.0.0.1", port))
        assert vehicle.mission_verified()
        with pytest.raises(BlockingIOError):
            stranger.recv(4096)


def test_two_vehicles_with_one_system_id_are_refused_before_arming() -> None:
    """Both send to the port that is listened at: commands must not alternate between them."""
    port = free_udp_port()
    ours, theirs = f"udpin:127.0.0.1:{port}", (f"udpout:127.0.0.1:{port}",)

    def listen(vehicle: ConnectedVehicle) -> None:
        end_s = time.monotonic() + 20.0
        while time.monotonic() < end_s:
            vehicle.reports(0.1)

    with (
        launch.run(START, speedup=20.0, listen=theirs),
        launch.run(START, speedup=20.0, listen=theirs),
        pytest.raises(VehicleError, match=r"two vehicles with system id 1 .* from 127\.0\.0\.1:\d+ and 127"),
        connect(ours, speedup=20.0, limit_s=60.0) as vehicle,
    ):
        listen(vehicle)


def test_another_vehicle_with_its_system_id_is_told_once_in_flight(monkeypatch: pytest.MonkeyPatch) -> None:
    """It may be switched on beside the place; the one that flies alone is listened to, none more is armed."""
    monkeypatch.setattr("flight_replay.vehicle.link.vehicle_sender.BOTH_S", 0.0)
    port, events = free_udp_port(), list[Event]()
    beat = dialect.MAVLink_heartbeat_message(2, 3, 0, 9, 4, 3).pack(dialect.MAVLink(None, 1, 1))
    with (
        copter(listen=f"udpout:127.0.0.1:{port}", events=events) as vehicle,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other,
    ):
        other.setblocking(False)
        other.bind(("127.0.0.1", 0))
        vehicle.request_arm()
        end_s, modes = time.monotonic() + 20.0, set[str]()
        with _speaking(other, beat, port):
            while not any(isinstance(event, Notice) for event in events) and time.monotonic() < end_s:
                modes |= {report.mode for report in vehicle.reports(0.1) if isinstance(report, Heartbeat)}
            for _ in range(5):
                modes |= {report.mode for report in vehicle.reports(0.1) if isinstance(report, Heartbeat)}
            with pytest.raises(VehicleError, match="two vehicles with system id 1"):
                vehicle.request_arm()
            assert vehicle.reports(20.0), "RTL can still be commanded"
        (notice,) = [event.text for event in events if isinstance(event, Notice)]
        assert f"the one at 127.0.0.1:{other.getsockname()[1]} ignored" in notice
        assert modes == {"STABILIZE"}
        with pytest.raises(BlockingIOError):
            other.recv(4096)


def test_connecting_is_quick() -> None:
    """A few parameters are read, some of them again, not 1,340; phases and progress are events."""
    events: list[Event] = []
    with (
        launch.run(START, speedup=20.0) as running,
        fault_link(running.connection) as link,
        connect(link.connection, speedup=20.0, listener=events.append, limit_s=60.0) as vehicle,
    ):
        vehicle.upload(ROUTE, events.append)
    assert 0 < sum(message.get_type() == "PARAM_VALUE" for message in link.from_vehicle) < 300
    assert [e.phase for e in events if isinstance(e, PhaseStarted)] == [
        Phase.CONNECT,
        Phase.UPLOAD,
        Phase.CLOSE,
    ]
    done = [e.done for e in events if isinstance(e, Progress)]
    assert done[-1] == len(ROUTE.items)
    assert done == sorted(done)


def test_a_key_that_others_can_read_is_told_with_the_command_that_mends_it(tmp_path: Path) -> None:
    """The command can be pasted, whatever the file is called."""
    key = tmp_path / "my key"
    key.write_text("a passphrase")
    key.chmod(0o644)
    events: list[Event] = []
    with (
        pytest.raises(VehicleError, match="refused"),
        connect("tcp:127.0.0.1:1", signing_key=key, listener=events.append),
    ):
        raise AssertionError
    (notice,) = (event for event in events if isinstance(event, Notice))
    assert notice.text == f"other users can read the signing key {key}; run: chmod 600 '{key}'"


def test_an_armed_vehicle_is_not_changed() -> None:
    """Neither its mission nor its parameters; it may be flying by them."""
    with (
        launch.run(START, speedup=20.0, parameters={"DISARM_DELAY": 0.0}) as running,
        connect(running.connection, speedup=20.0, limit_s=60.0) as vehicle,
    ):
        vehicle.upload(ROUTE)
        wait_armed(vehicle)
        armed = "the vehicle is armed, in GUIDED: its {}; land and disarm it, then run this again"
        with pytest.raises(VehicleError, match=armed.format("mission is not replaced")):
            vehicle.upload(Mission(ROUTE.items[:3]))
        with pytest.raises(VehicleError, match=armed.format("parameters are not changed")):
            vehicle.set_known_parameters({"WPNAV_SPEED": 200.0})
        with pytest.raises(VehicleError, match=armed.format("parameters are not changed")):
            vehicle.parameters_set({"WPNAV_SPEED": 200.0})
        assert vehicle.parameters(["WPNAV_SPEED"]) == {"WPNAV_SPEED": 1000.0}
        assert vehicle.mission_verified()


@pytest.mark.parametrize(("reboots", "error"), [(True, VehicleError), (False, MissionError)])
def test_a_vehicle_that_reboots_in_an_upload_does_not_refuse_its_items(
    monkeypatch: pytest.MonkeyPatch, reboots: bool, error: type[FlightReplayError]
) -> None:
    """It answers what it is sent while it boots with a refusal, and tells its clock later."""
    here = VehicleState(10.0, 47.0, 8.0, 0.0, (0, 0, 0), None, "STABILIZE", False)

    def refuse(*_: object) -> None:
        raise MissionError("the vehicle refused mission item 40: unsupported")

    with copter() as vehicle:
        vehicle.wait_position(60.0)
        last: list[Report] = [Rebooted(), here] if reboots else [here]
        waiting = [[here], [], [Heartbeat("STABILIZE", False)], last]
        monkeypatch.setattr(vehicle, "reports", lambda timeout_s: waiting.pop(0))
        monkeypatch.setattr(vehicle._storage, "upload", refuse)
        with pytest.raises(error, match="rebooted during" if reboots else "refused mission item"):
            vehicle.upload(ROUTE)
        assert waiting == []


def test_a_vehicle_that_does_not_tell_whether_it_is_armed_is_not_changed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Without a heartbeat nobody knows."""
    monkeypatch.setattr(module, "_NO_DATA_S", 0.1)
    monkeypatch.setattr(module, "_HEARTBEAT_AGE_S", -1.0)
    with copter() as vehicle, pytest.raises(VehicleError, match="lost: no heartbeat for 0 s; check the link"):
        vehicle.link.close()
        vehicle.upload(ROUTE)


def test_an_old_copter_is_identified_by_its_capabilities() -> None:
    """3.3: no MISSION_ITEM_INT."""
    with copter(old_copter()) as vehicle:
        assert not vehicle.identity.takes_item_int
        assert vehicle.identity.simulated
        vehicle.upload(ROUTE)
        assert vehicle.mission_verified()


def test_of_several_vehicles_the_first_is_flown() -> None:
    """The lowest system id; a notice names the others."""
    events: list[Event] = []
    with copter(Faults(other_heartbeats=(SECOND_COPTER,)), events=events) as vehicle:
        assert vehicle.identity.system == 1
    assert Notice("vehicle 2 is also on this link; it is ignored", warning=True) in events


def test_a_position_is_waited_for() -> None:
    """Until the GPS has one."""
    with copter() as vehicle:
        at = vehicle.wait_position(60.0)
        assert at.lat_deg == pytest.approx(START.lat_deg, abs=1e-5)
        assert at.alt_m == pytest.approx(0, abs=1)


def test_waiting_for_a_position_has_a_limit() -> None:
    """What is waited for is emitted meanwhile."""
    waits: list[Event] = []
    with copter(speedup=0.1) as vehicle, pytest.raises(PhaseTimeoutError, match="no position after 1 s"):
        vehicle.wait_position(1.2, waits.append)
    assert waits == [Waiting(Phase.PREARM, "no position yet")]


def test_parameters_are_set_while_the_context_lasts() -> None:
    """Speed limits in SI units, under the vehicle's own names."""
    with copter() as vehicle:
        wanted = vehicle.limits_as_parameters({"wp_speed_m_s": 14.0})
        assert wanted == {"WPNAV_SPEED": 1400.0}
        with vehicle.parameters_set(wanted):
            assert vehicle.parameters(wanted) == wanted
        assert vehicle.parameters(wanted) == {"WPNAV_SPEED": 1000.0}


def test_a_link_lost_before_takeoff_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is reported as a lost link, not as a missing position."""
    monkeypatch.setattr(module, "_NO_DATA_S", 0.5)
    with copter() as vehicle:
        vehicle.link.close()
        vehicle.reports(0.0)
        with pytest.raises(VehicleError, match="link to the vehicle lost: no data for"):
            vehicle.wait_position(60.0)


def test_the_position_is_the_latest() -> None:
    """Not one that was queued while a person was asked, for example."""
    with copter() as vehicle:
        first = vehicle.wait_position(60.0)
        heard: queue.SimpleQueue[int] = queue.SimpleQueue()
        vehicle.link.add_receiver(lambda message: heard.put(getattr(message, "time_boot_ms", 0)))
        begun_ms = 0
        while not begun_ms or heard.get(timeout=60) < begun_ms + 2000:
            begun_ms = begun_ms or heard.get(timeout=60)
        assert vehicle.wait_position(60.0).time_s > first.time_s + 1.0


def test_a_simulators_speedup_is_set_if_it_differs() -> None:
    """Parameters that the vehicle does not have are skipped."""
    with copter() as vehicle:
        vehicle.set_speedup(8.0)
        assert vehicle.parameters(["SIM_SPEEDUP"]) == {"SIM_SPEEDUP": 8.0}
        vehicle.set_known_parameters({"SIM_SPEEDUP": 9.0, "NO_SUCH_NAME": 1.0})
        assert vehicle.parameters(["SIM_SPEEDUP", "NO_SUCH_NAME"]) == {"SIM_SPEEDUP": 9.0}
        vehicle.set_speedup(9.0)
        assert vehicle.link.speedup == 9.0


@pytest.mark.parametrize(
    ("told", "pace"),
    [
        ({"SIM_SPEEDUP": 7.0}, 7.0),
        ({}, 1.0),
        ({"SIM_SPEEDUP": 0.0}, 100.0),
        ({"SIM_SPEEDUP": math.nan}, 100.0),
    ],
    ids=["told", "not told", "as fast as it goes", "no number"],
)
def test_the_speedup_of_a_running_simulator_is_kept(
    told: dict[str, float], pace: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Heartbeats are sent often enough for it, whatever SIM_SPEEDUP is."""
    with copter() as vehicle:
        monkeypatch.setattr(vehicle, "parameters", lambda names: told)
        vehicle.set_speedup(None)
        assert vehicle.link.speedup == pace


FENCE = {"FENCE_ENABLE": 1.0, "FENCE_TYPE": 7.0}
V1_ONLY = Firmware(mavlink1=True)
WITHOUT_FENCE = Firmware(version=(4, 0, 7), capabilities=1 | 2 | 4 | 8 | 8192)


def fence_notices(firmware: Firmware, **parameters: float) -> list[str]:
    """Connect, and read the fence, which has no areas: what was said of it."""
    events: list[Event] = []
    own = FENCE | parameters
    with (
        launch.run(START, speedup=20.0, faults=Faults(firmware=firmware), parameters=own) as running,
        connect(running.connection, speedup=20.0, listener=events.append, limit_s=60.0) as vehicle,
    ):
        assert vehicle.fence_areas() == ()
    return [event.text for event in events if isinstance(event, Notice)]


@pytest.mark.parametrize("protocol", [1.0, 2.0], ids=["once it hears MAVLink 2", "at once"])
def test_a_fence_is_read_over_mavlink_2(protocol: float) -> None:
    """Ports of older firmware begin with MAVLink 1, and go on with MAVLink 2 when they hear it."""
    assert fence_notices(Firmware(), SERIAL0_PROTOCOL=protocol, FENCE_TOTAL=6.0) == []


@pytest.mark.parametrize(
    ("firmware", "parameters", "warning"),
    [
        (V1_ONLY, {"FENCE_TOTAL": 0.0}, "not checked against circles of the vehicle's fence"),
        (V1_ONLY, {"FENCE_TYPE": 3.0, "FENCE_TOTAL": 6.0}, ""),
        (V1_ONLY, {"FENCE_ENABLE": 0.0, "FENCE_TOTAL": 6.0}, ""),
        (WITHOUT_FENCE, {"FENCE_TOTAL": 6.0}, "not checked against the polygon of the vehicle's fence"),
        (WITHOUT_FENCE, {"FENCE_TOTAL": 0.0}, ""),
    ],
    ids=["perhaps circles", "no areas", "off", "not told", "no polygon"],
)
def test_a_fence_that_cannot_be_read_is_told(
    firmware: Firmware, parameters: dict[str, float], warning: str
) -> None:
    """The vehicle can be flown; only where its fence may have areas there is a warning."""
    told = fence_notices(firmware, **parameters)
    assert len(told) == bool(warning)
    assert all(warning in text for text in told)


def test_polygons_that_need_mavlink_2_are_an_error() -> None:
    """It names what to set; the link is not at fault."""
    with pytest.raises(VehicleError, match=r"only be read over MAVLink 2, .*; set SERIALn_PROTOCOL"):
        fence_notices(V1_ONLY, FENCE_TOTAL=6.0)


def test_a_plane_is_not_a_multicopter() -> None:
    """Its name says fixed wing."""
    with copter(Faults(firmware=Firmware(vehicle_type=1, name="ArduPlane"))) as vehicle:
        assert vehicle.identity.kind == "fixed wing"
        assert not vehicle.identity.is_multicopter


def test_a_ground_stations_heartbeat_is_not_a_vehicles() -> None:
    """The error says from where heartbeats came."""
    station = dialect.MAVLink(None, 254, 190)
    beat = dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3).pack(station)
    port = free_udp_port()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))

        with (
            pytest.raises(VehicleError, match="in 1 s, only from system/component 254/190; check"),
            _speaking(other, beat, port),
            connect(f"udpin:127.0.0.1:{port}", limit_s=1.0),
        ):
            raise AssertionError


@contextmanager
def _speaking(other: socket.socket, frame: bytes, port: int) -> Iterator[None]:
    """Send a frame again and again."""
    over = threading.Event()

    def speak() -> None:
        while not over.wait(0.1):
            other.sendto(frame, ("127.0.0.1", port))

    thread = threading.Thread(target=speak)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def test_the_link_is_closed_when_the_listener_fails() -> None:
    """An error while CLOSE is emitted leaves neither thread nor socket behind."""

    def listener(event: Event) -> None:
        if event == PhaseStarted(Phase.CLOSE):
            raise BrokenPipeError

    with launch.run(START, speedup=20.0) as running:
        with pytest.raises(BrokenPipeError), connect(running.connection, listener=listener) as vehicle:
            thread = vehicle.link._thread
        assert not thread.is_alive()
