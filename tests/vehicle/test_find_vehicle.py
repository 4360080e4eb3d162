"""identity.find_vehicle: nobody is heard; it is said while waiting, and what to check afterwards."""

import pytest

from flight_replay.events import Event, Phase, Waiting
from flight_replay.exceptions import VehicleError
from flight_replay.vehicle.identity import find_vehicle
from flight_replay.vehicle.link.connection_string import silence_hint
from flight_replay.vehicle.link.discovery import DiscoveredVehicle, VehicleDiscovery


class Silent(VehicleDiscovery):
    """Waits by counting; hears a vehicle after so many seconds."""

    def __init__(self, heard_s: float = float("inf")) -> None:
        super().__init__()
        self.waited_s, self._heard_s = 0.0, heard_s

    def wait(self, limit_s: float) -> DiscoveredVehicle | None:
        self.waited_s += limit_s
        return DiscoveredVehicle(1, 1, 2, 3) if self.waited_s >= self._heard_s else None


def test_waiting_is_said_every_few_seconds() -> None:
    """And the error has the hint."""
    said: list[Event] = []
    silent = Silent()
    with pytest.raises(VehicleError, match=r"on udp:0\.0\.0\.0:14550 in 12 s; check this"):
        find_vehicle(silent, "udp:0.0.0.0:14550", "check this", 12.0, said.append)
    assert silent.waited_s == 12.0
    assert said == [
        Waiting(Phase.CONNECT, f"no heartbeat of a vehicle for {waited} s") for waited in (5, 10, 12)
    ]


def test_a_wait_without_end_ends_with_a_vehicle() -> None:
    """--wait."""
    assert find_vehicle(Silent(3600.0), "udp:0.0.0.0:14550", "", float("inf")).system == 1


@pytest.mark.parametrize(
    ("connection", "words"),
    [
        ("udp:127.0.0.1:14550", "firewall"),
        ("127.0.0.1:14550", "--out=udpout:"),
        ("/dev/ttyUSB0", "--baud, now 57600"),
        ("/dev/ttyUSB0,115200", "--baud, now 115200"),
        ("tcp:127.0.0.1:5760", "address of a vehicle"),
    ],
)
def test_the_hint_fits_the_link(connection: str, words: str) -> None:
    """Nobody checks the baud rate of a UDP port."""
    assert words in silence_hint(connection, 57600)
