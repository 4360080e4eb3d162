"""The adapter to DroneKit: importable on any Python, receives the vehicle, and has no side effects."""

from __future__ import annotations

import collections
import logging
import subprocess
import sys
from typing import Any

import pytest

from flight_replay.exceptions import VehicleError
from flight_replay.mavlink import dialect
from flight_replay.vehicle.dronekit_adapter import dronekit_vehicle, import_dronekit


class FakeLink:
    """Keeps what is sent."""

    def __init__(self) -> None:
        self.sent: list[Any] = []
        self.receivers: list[Any] = []

    def send(self, message: Any) -> None:
        self.sent.append(message)

    def add_receiver(self, receiver: Any, *, of_vehicle: bool) -> None:
        assert of_vehicle
        self.receivers.append(receiver)


def arrived(message: Any) -> Any:
    frame = message.pack(dialect.MAVLink(None, 7, 1))
    return dialect.MAVLink(None).parse_buffer(frame)[0]


def connected() -> tuple[FakeLink, Any]:
    link = FakeLink()
    return link, dronekit_vehicle(link, 7)  # type: ignore[arg-type]


def test_the_import_leaves_collections_unchanged() -> None:
    """The name that DroneKit needs exists only during the import."""
    assert import_dronekit().Vehicle
    assert not hasattr(collections, "MutableMapping")


def test_dronekit_is_imported_only_to_connect() -> None:
    """Importing the vehicle and supervisor packages does not import it."""
    code = "import sys, flight_replay.vehicle, flight_replay.supervisor; print('dronekit' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_without_dronekit_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    """The error has the command to install it."""
    monkeypatch.setitem(sys.modules, "dronekit", None)
    with pytest.raises(VehicleError, match="pip install dronekit future"):
        import_dronekit()


def test_the_root_logger_stays_unchanged() -> None:
    """DroneKit would configure logging for the whole program."""
    root = logging.getLogger()
    kept = root.handlers[:]
    root.handlers.clear()
    try:
        connected()
        assert root.handlers == []
    finally:
        root.handlers[:] = kept


def test_dronekit_receives_the_vehicles_messages() -> None:
    link, drone = connected()
    (deliver,) = link.receivers
    deliver(arrived(dialect.MAVLink_heartbeat_message(2, 3, 128, 4, 4, 3)))
    assert (drone.mode.name, drone.armed) == ("GUIDED", True)


def test_an_error_in_dronekit_does_no_harm() -> None:
    """A mode newer than DroneKit raises in it."""
    link, drone = connected()
    (deliver,) = link.receivers
    deliver(arrived(dialect.MAVLink_heartbeat_message(2, 3, 128, 99, 4, 3)))
    deliver(arrived(dialect.MAVLink_sys_status_message(0, 0, 0, 0, 12100, 100, 55, 0, 0, 0, 0, 0, 0)))
    assert drone.battery.voltage == 12.1


def test_what_dronekit_sends_goes_to_the_vehicle_over_our_link() -> None:
    """Its own commands, ``send_mavlink``, and messages without an address."""
    link, drone = connected()
    drone.send_mavlink(dialect.MAVLink_param_request_list_message(0, 0))
    drone._master.mav.command_long_send(0, 0, 400, 0, 1, 0, 0, 0, 0, 0, 0)
    drone.send_mavlink(dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 0, 3))
    assert [m.get_type() for m in link.sent] == ["PARAM_REQUEST_LIST", "COMMAND_LONG", "HEARTBEAT"]
    assert [getattr(m, "target_system", None) for m in link.sent] == [7, 7, None]
    drone.close()
