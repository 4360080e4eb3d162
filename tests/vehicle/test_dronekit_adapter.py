"""The wall around DroneKit: importable anywhere, hears only the vehicle, changes nothing for others."""

from __future__ import annotations

import collections
import logging
import subprocess
import sys
from typing import Any

import pytest

from flight_replay.errors import VehicleError
from flight_replay.mavlink import dialect
from flight_replay.vehicle.dronekit_adapter import dronekit_vehicle, import_dronekit


class FakeLink:
    """Keeps what is sent."""

    def __init__(self) -> None:
        self.sent: list[Any] = []
        self.receivers: list[Any] = []

    def send(self, message: Any) -> None:
        self.sent.append(message)

    def add_receiver(self, receiver: Any) -> None:
        self.receivers.append(receiver)


def arrived(message: Any, system: int, component: int) -> Any:
    frame = message.pack(dialect.MAVLink(None, system, component))
    return dialect.MAVLink(None).parse_buffer(frame)[0]


def connected() -> tuple[FakeLink, Any]:
    link = FakeLink()
    return link, dronekit_vehicle(link, 7, 1)  # type: ignore[arg-type]


def test_the_import_leaves_collections_as_it_was() -> None:
    """The name that DroneKit needs is there only while it is imported."""
    assert import_dronekit().Vehicle
    assert not hasattr(collections, "MutableMapping")


def test_nobody_else_needs_dronekit() -> None:
    """Importing the package's planning side, and its vehicle room, starts no DroneKit."""
    code = "import sys, flight_replay.vehicle, flight_replay.supervisor; print('dronekit' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_without_dronekit_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    """The line to install it is in the error."""
    monkeypatch.setitem(sys.modules, "dronekit", None)
    with pytest.raises(VehicleError, match="pip install dronekit future"):
        import_dronekit()


def test_the_root_logger_stays_as_it_was() -> None:
    """DroneKit configures logging for the whole program; here it may not."""
    root = logging.getLogger()
    kept = root.handlers[:]
    root.handlers.clear()
    try:
        connected()
        assert root.handlers == []
    finally:
        root.handlers[:] = kept


def test_dronekit_hears_the_vehicle_and_nobody_else() -> None:
    """A gimbal of the same system and a neighbour do not change what DroneKit knows."""
    link, drone = connected()
    (deliver,) = link.receivers
    deliver(arrived(dialect.MAVLink_heartbeat_message(2, 3, 128, 4, 4, 3), 7, 1))
    for source in ((7, 154), (8, 1)):
        deliver(arrived(dialect.MAVLink_heartbeat_message(2, 3, 0, 5, 4, 3), *source))
    assert (drone.mode.name, drone.armed) == ("GUIDED", True)


def test_a_message_that_dronekit_cannot_handle_does_no_harm() -> None:
    """A mode newer than DroneKit makes it stumble, not us."""
    link, drone = connected()
    (deliver,) = link.receivers
    deliver(arrived(dialect.MAVLink_heartbeat_message(2, 3, 128, 99, 4, 3), 7, 1))
    deliver(arrived(dialect.MAVLink_sys_status_message(0, 0, 0, 0, 12100, 100, 55, 0, 0, 0, 0, 0, 0), 7, 1))
    assert drone.battery.voltage == 12.1


def test_what_dronekit_sends_goes_to_the_vehicle_over_our_link() -> None:
    """Its own commands, its public way to send, and messages without an address."""
    link, drone = connected()
    drone.send_mavlink(dialect.MAVLink_param_request_list_message(0, 0))
    drone._master.mav.command_long_send(0, 0, 400, 0, 1, 0, 0, 0, 0, 0, 0)
    drone.send_mavlink(dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 0, 3))
    assert [m.get_type() for m in link.sent] == ["PARAM_REQUEST_LIST", "COMMAND_LONG", "HEARTBEAT"]
    assert [getattr(m, "target_system", None) for m in link.sent] == [7, 7, None]
    drone.close()
