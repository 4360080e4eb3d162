"""Links over the network: real sockets on loopback, ports that the system chooses."""

from __future__ import annotations

import errno
import socket
import time
from collections.abc import Callable, Iterator

import pytest

from flight_replay.exceptions import SimulatorError
from flight_replay.mavlink import dialect, robust_parser
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.autopilot.parameter_table import Parameters
from flight_replay.simulator.server.addresses import NetworkAddress, parse_address
from flight_replay.simulator.server.endpoint import Endpoint, StepScheduler
from flight_replay.simulator.server.links import ListenSocket, TcpClientSocket
from tests.helpers.sim_station import GUIDED, START

LOCAL = "127.0.0.1"


class Client:
    """A station on a socket."""

    def __init__(self, sock: socket.socket, system: int = 255) -> None:
        sock.settimeout(60)
        self.socket = sock
        self.mav = dialect.MAVLink(None, system, 190)
        self._decoder = robust_parser()

    def send(self, message: object) -> None:
        self.socket.sendall(message.pack(self.mav))  # type: ignore[attr-defined]

    def hear(self) -> list[object]:
        self.socket.settimeout(0)
        try:
            return self._decoder.parse_buffer(self.socket.recv(65536)) or []
        except OSError:
            return []


@pytest.fixture
def opened() -> Iterator[Callable[..., Endpoint]]:
    """Opens endpoints, and closes them after the test."""
    endpoints: list[Endpoint] = []

    def open_endpoint(*addresses: str) -> Endpoint:
        autopilot = Autopilot(START, parameters=Parameters({"SIM_SPEEDUP": 1000}))
        endpoints.append(Endpoint(autopilot, [parse_address(each) for each in addresses]))
        return endpoints[-1]

    yield open_endpoint
    for endpoint in endpoints:
        endpoint.close()


def connect(endpoint: Endpoint, number: int = 0, system: int = 255) -> Client:
    return Client(socket.create_connection((LOCAL, endpoint.addresses[number].port)), system)


def received(endpoint: Endpoint, client: Client, kind: str) -> object:
    """The first message of a kind; steps the vehicle meanwhile, at most a minute of wall time."""
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        endpoint.exchange(0.01)
        endpoint.step()
        for message in client.hear():
            if message.get_type() == kind:  # type: ignore[attr-defined]
                return message
    raise AssertionError(f"no {kind}")


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("tcp:127.0.0.1:5760", NetworkAddress("tcp", "127.0.0.1", 5760)),
        ("tcpin:0.0.0.0:0", NetworkAddress("tcp", "0.0.0.0", 0)),
        ("udp:localhost:14550", NetworkAddress("udpin", "localhost", 14550)),
        ("udpout:10.0.0.2:14550", NetworkAddress("udpout", "10.0.0.2", 14550)),
        ("udpin:127.0.0.1:14550", NetworkAddress("udpin", "127.0.0.1", 14550)),
        ("tcp:[::1]:5760", NetworkAddress("tcp", "::1", 5760)),
    ],
)
def test_connection_strings_are_those_of_mavlink_tools(text: str, address: NetworkAddress) -> None:
    """Each form names a kind of link, a host and a port."""
    assert parse_address(text) == address
    assert parse_address(str(address)) == address


@pytest.mark.parametrize("text", ["5760", "tcp:5760", "tcp::5760", "http:a:1", "tcp:a:b", "udp:a:70000", ""])
def test_other_strings_are_refused_with_an_example(text: str) -> None:
    """The message shows what a valid address looks like."""
    with pytest.raises(SimulatorError, match=r"use tcp:127\.0\.0\.1:5760"):
        parse_address(text)


def test_a_port_in_use_is_one_clear_sentence(opened: Callable[..., Endpoint]) -> None:
    """It names the port, and what was opened before is closed again."""
    taken = opened(f"tcp:{LOCAL}:0").addresses[0]
    with pytest.raises(SimulatorError, match=f"cannot listen on {taken}: .*in use; choose another address"):
        opened(f"tcp:{LOCAL}:0", str(taken))
    with pytest.raises(SimulatorError, match=r"cannot listen on tcp:192\.0\.2\.1:5760"):
        ListenSocket(NetworkAddress("tcp", "192.0.2.1", 5760))


def test_several_stations_at_once(opened: Callable[..., Endpoint]) -> None:
    """TCP clients on one port and a second port all hear the vehicle, and its answers to each other."""
    endpoint = opened(f"tcp:{LOCAL}:0", f"tcp:{LOCAL}:0")
    clients = [connect(endpoint, 0), connect(endpoint, 0, 254), connect(endpoint, 1, 253)]
    for client in clients:
        received(endpoint, client, "HEARTBEAT")
    clients[0].send(dialect.MAVLink_param_set_message(1, 1, b"RTL_ALT", 2222, 6))
    for client in clients:
        assert received(endpoint, client, "PARAM_VALUE").param_value == 2222  # type: ignore[attr-defined]
        client.socket.close()


def test_stations_come_and_go(opened: Callable[..., Endpoint]) -> None:
    """A client that hangs up is forgotten; the next one is served."""
    endpoint = opened(f"tcp:{LOCAL}:0")
    for _ in range(3):
        client = connect(endpoint)
        received(endpoint, client, "HEARTBEAT")
        client.socket.close()
        deadline = time.monotonic() + 60
        while endpoint.stations and time.monotonic() < deadline:
            endpoint.exchange(0.01)
            endpoint.step()
        assert endpoint.stations == 0


def test_a_simulator_without_descriptors_goes_on(
    opened: Callable[..., Endpoint], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A station that cannot be accepted takes none away from the others; it is accepted later."""
    endpoint = opened(f"tcp:{LOCAL}:0")
    first = connect(endpoint)
    received(endpoint, first, "HEARTBEAT")

    def accept(self: socket.socket) -> None:
        raise OSError(errno.EMFILE, "Too many open files")

    with monkeypatch.context() as without:
        without.setattr(socket.socket, "accept", accept)
        second = connect(endpoint)
        received(endpoint, first, "HEARTBEAT")
        assert endpoint.stations == 1
    received(endpoint, second, "HEARTBEAT")
    for client in (first, second):
        client.socket.close()


def test_messages_between_stations_are_passed_on(opened: Callable[..., Endpoint]) -> None:
    """What is addressed to a station goes there; what is addressed to another vehicle is not obeyed."""
    endpoint = opened(f"tcp:{LOCAL}:0")
    one, two = connect(endpoint), connect(endpoint, system=42)
    for client in (one, two):
        client.send(dialect.MAVLink_param_request_read_message(1, 1, b"RTL_ALT", -1))
        received(endpoint, client, "PARAM_VALUE")
    one.send(dialect.MAVLink_ping_message(1, 99, 42, 0))
    ping = received(endpoint, two, "PING")
    assert (ping.seq, ping.get_srcSystem()) == (99, 255)  # type: ignore[attr-defined]
    one.send(dialect.MAVLink_set_mode_message(7, 1, GUIDED))
    one.send(dialect.MAVLink_param_request_read_message(1, 154, b"RTL_ALT", -1))
    one.send(dialect.MAVLink_param_request_read_message(1, 1, b"LAND_SPEED", -1))
    assert received(endpoint, one, "PARAM_VALUE").param_id == "LAND_SPEED"  # type: ignore[attr-defined]
    assert received(endpoint, one, "HEARTBEAT").custom_mode == 0  # type: ignore[attr-defined]
    for client in (one, two):
        client.socket.close()


def test_udpout_sends_to_its_address_and_hears_the_answers(opened: Callable[..., Endpoint]) -> None:
    """A ground station that waits on a port hears the vehicle first, and can then talk to it."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind((LOCAL, 0))
        endpoint = opened(f"udpout:{LOCAL}:{sock.getsockname()[1]}")
        client = Client(sock)
        endpoint.step()
        _, vehicle = sock.recvfrom(65536)
        sock.connect(vehicle)
        client.send(dialect.MAVLink_param_request_read_message(1, 1, b"RTL_ALT", -1))
        assert received(endpoint, client, "PARAM_VALUE").param_value == 1500  # type: ignore[attr-defined]


def test_udp_can_wait_for_a_first_datagram(opened: Callable[..., Endpoint]) -> None:
    """udpin: is silent until somebody speaks, and then answers there; refusals do no harm."""
    endpoint = opened(f"udpin:{LOCAL}:0")
    endpoint.step()
    for _ in range(2):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
            sock.connect((LOCAL, endpoint.addresses[0].port))
            client = Client(sock)
            client.send(dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 0, 3))
            received(endpoint, client, "HEARTBEAT")
        for _ in range(60):
            endpoint.step()
            endpoint.exchange(0)


def test_a_station_that_never_reads_is_let_go(opened: Callable[..., Endpoint]) -> None:
    """Unsent bytes are bounded: first telemetry pauses, then the connection ends."""
    here, there = socket.socketpair()
    with there:
        connection = TcpClientSocket.__new__(TcpClientSocket)
        here.setblocking(False)
        connection.socket, connection.is_open, connection._unsent = here, True, bytearray()
        while connection.has_room:
            connection.write(b"x" * 65536)
            connection.flush()
        assert connection.is_open
        for _ in range(70):
            connection.write(b"x" * 65536)
        assert not connection.is_open
        connection.close()


def test_time_is_paced_by_the_clock_and_never_skipped() -> None:
    """Steps come at speedup times real time; a stall makes the vehicle late, not jumpy."""
    scheduler = StepScheduler(100.0)
    assert scheduler.wait_s(100.0) == 0
    scheduler.stepped(100.0, 0.02, 2.0)
    assert scheduler.wait_s(100.0) == pytest.approx(0.01)
    assert scheduler.wait_s(100.01) == pytest.approx(0)
    scheduler.stepped(107.0, 0.02, 2.0)
    scheduler.stepped(107.0, 0.02, 2.0)
    assert scheduler.wait_s(107.0) == pytest.approx(0.01)


def test_running_follows_sim_speedup(opened: Callable[..., Endpoint]) -> None:
    """With a clock that ticks 1 ms at each look, vehicle time is speedup times that clock's."""
    endpoint = opened(f"udpin:{LOCAL}:0")
    autopilot = endpoint.autopilot
    autopilot.parameters.assign("SIM_SPEEDUP", 5)
    ticks = iter(range(10**6))
    endpoint.exchange = lambda timeout_s: None  # type: ignore[method-assign]
    now = [0.0]

    def clock() -> float:
        now[0] = next(ticks) / 1000
        return now[0]

    endpoint.run(lambda: now[0] >= 2.0, clock)
    assert autopilot.time_s == pytest.approx(10.0, abs=0.1)
