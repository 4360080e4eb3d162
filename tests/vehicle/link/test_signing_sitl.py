"""Signing against a real ArduCopter in ArduPilot SITL.

SERIAL0 takes unsigned messages always (GCS_Signing.cpp: it is the USB port), so SERIAL1 is tried.
"""

from __future__ import annotations

import hashlib
import os
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from flight_replay import supervisor
from flight_replay.cli import restore
from flight_replay.events import Event, Notice
from flight_replay.exceptions import VehicleError
from flight_replay.mavlink import dialect, robust_parser
from flight_replay.mission import formats
from flight_replay.supervisor import Plan
from flight_replay.vehicle import ConnectedVehicle, connect
from flight_replay.vehicle.link.ground_stations import ground_stations
from flight_replay.vehicle.link.signing import is_signed
from flight_replay.vehicle.sitl import simulator
from tests.cli.test_real_copter import Clock
from tests.helpers.fault_runs import ROUTE, START

pytestmark = [
    pytest.mark.sitl,
    pytest.mark.skipif("SITL_BINARY" not in os.environ, reason="SITL_BINARY names no ArduCopter"),
]

SPEEDUP = 4.0
PASSPHRASE = "only the pilot knows"


@contextmanager
def signing_copter() -> Iterator[str]:
    """The connection string of SERIAL1 of a copter that was given the key over SERIAL0."""
    with simulator("sitl", None, START, speedup=SPEEDUP) as usb, connect(usb, speedup=SPEEDUP) as vehicle:
        if not vehicle.identity.takes_item_int:
            pytest.skip("3.3 knows no signing")
        now = int((time.time() - 1_420_070_400) * 1e5)
        key = list(hashlib.sha256(PASSPHRASE.encode()).digest())
        vehicle.link.send(dialect.MAVLink_setup_signing_message(1, 1, key, now))
        host, _, port = usb.rpartition(":")
        yield f"{host}:{int(port) + 2}"


@contextmanager
def key_file(path: Path, passphrase: str = PASSPHRASE) -> Iterator[Path]:
    path.write_text(passphrase)
    path.chmod(0o600)
    yield path


def fly(vehicle: ConnectedVehicle, events: list[Event]) -> supervisor.FlightRecord:
    vehicle.upload(ROUTE)
    return supervisor.fly(
        vehicle, Clock(), Plan(mission=ROUTE, duration_s=10.0, takeoff_altitude_m=8.0), events.append
    )


def test_a_copter_that_wants_signatures_is_flown_with_the_key(tmp_path: Path) -> None:
    """Without it, and with another one, nothing is uploaded; each failure names the option or the key."""
    events: list[Event] = []
    with signing_copter() as connection:
        with (
            pytest.raises(VehicleError, match="upload stopped at mission item 0"),
            connect(connection, speedup=SPEEDUP, listener=events.append) as vehicle,
        ):
            vehicle.upload(ROUTE)
        warnings = [event.text for event in events if isinstance(event, Notice)]
        assert any("give its key with --signing-key" in text for text in warnings)
        with (
            key_file(tmp_path / "wrong", "a guess") as wrong,
            pytest.raises(VehicleError, match="is not signed with the key"),
            connect(connection, speedup=SPEEDUP, signing_key=wrong, limit_s=5.0),
        ):
            pass
        events.clear()
        with (
            key_file(tmp_path / "key") as key,
            connect(connection, speedup=SPEEDUP, signing_key=key, listener=events.append) as vehicle,
        ):
            record = fly(vehicle, events)
            assert vehicle.link.ignored == 0
    assert (record.ended, record.problem, record.rtl_confirmed) == ("duration", None, True)


def test_stations_and_restore_reach_a_copter_that_wants_signatures(tmp_path: Path) -> None:
    """A ground station without a key sees the copter, and its command is obeyed; a mission is restored."""
    saved = tmp_path / "saved.waypoints"
    formats.save(saved, ROUTE)
    with signing_copter() as connection, key_file(tmp_path / "key") as key:
        assert restore.main(["--signing-key", str(key), str(saved), connection]) == 0
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as station:
            station.bind(("127.0.0.1", 0))
            station.settimeout(30.0)
            address = f"udpout:127.0.0.1:{station.getsockname()[1]}"
            with (
                connect(connection, speedup=SPEEDUP, signing_key=key) as vehicle,
                ground_stations(vehicle.link, [address]),
            ):
                assert len(vehicle.mission_on_board().items) == len(ROUTE.items)
                assert answer_to_station(station) == dialect.MAV_RESULT_ACCEPTED


def answer_to_station(station: socket.socket) -> int:
    """The result of a command that an unsigned station sends to the copter."""
    mav = dialect.MAVLink(None, 255, 190)
    parser = robust_parser()
    request = dialect.MAVLink_command_long_message(
        1, 1, dialect.MAV_CMD_REQUEST_MESSAGE, 0, dialect.MAVLINK_MSG_ID_AUTOPILOT_VERSION, 0, 0, 0, 0, 0, 0
    )
    data, sender = station.recvfrom(4096)
    station.sendto(request.pack(mav), sender)
    end_s = time.monotonic() + 30.0
    while time.monotonic() < end_s:
        messages = parser.parse_buffer(data) or []
        assert not any(is_signed(bytes(message.get_msgbuf())) for message in messages)
        for message in messages:
            if message.get_type() == "COMMAND_ACK" and message.command == request.command:
                return int(message.result)
        data = station.recv(4096)
    raise AssertionError("no answer")
