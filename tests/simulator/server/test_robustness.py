"""Nothing that a station sends stops the simulator."""

from __future__ import annotations

import math
import random
from typing import Any

import pytest

from flight_replay.mavlink import dialect
from flight_replay.simulator.dynamics.parameter_names import PARAMETERS
from tests.helpers.sim_station import Station, item_at, sim

ODD = (0.0, 1.0, -1.0, 2.5, 1e6, -1e9, 3.4e38, -3.4e38, math.nan, math.inf, -math.inf)
HANDLED = (
    "COMMAND_LONG", "COMMAND_INT", "MISSION_ITEM", "MISSION_ITEM_INT", "MISSION_COUNT", "MISSION_REQUEST",
    "MISSION_REQUEST_INT", "MISSION_REQUEST_LIST", "MISSION_WRITE_PARTIAL_LIST", "MISSION_SET_CURRENT",
    "MISSION_CLEAR_ALL", "PARAM_REQUEST_READ", "SET_MODE", "REQUEST_DATA_STREAM", "PING", "TIMESYNC",
    "SET_POSITION_TARGET_LOCAL_NED", "SET_POSITION_TARGET_GLOBAL_INT", "FILE_TRANSFER_PROTOCOL", "HEARTBEAT",
)  # fmt: skip
COMMANDS = (16, 20, 21, 22, 115, 176, 178, 179, 192, 224, 241, 245, 300, 400, 401, 410, 510, 511, 512, 520)


def value(draw: random.Random, kind: str, name: str) -> Any:
    """A value of a field that may make no sense, but fits it."""
    if name == "command":
        return draw.choice(COMMANDS)
    if kind in ("float", "double"):
        return draw.choice(ODD)
    if kind == "char":
        return b"RTL_ALT"
    bits = int("".join(filter(str.isdigit, kind)))
    high = 2 ** min(bits, 31 if kind.startswith("u") else 32) // (1 if kind.startswith("u") else 2) - 1
    low = 0 if kind.startswith("u") else -high - 1
    return draw.choice((low, 0, 1, 2, 3, high, draw.randint(0, high)))


def odd_message(draw: random.Random) -> Any:
    """A message of a kind that is acted on, addressed to the copter, full of odd values."""
    kind = getattr(dialect, f"MAVLink_{draw.choice(HANDLED).lower()}_message")
    fields: list[Any] = []
    for name, type_name in zip(kind.fieldnames, kind.fieldtypes, strict=True):
        if name in ("target_system", "target_component"):
            fields.append(1)
        elif name == "payload":
            fields.append([draw.randint(0, 255) for _ in range(251)])
        else:
            fields.append(value(draw, type_name, name))
    return kind(*fields)


def bother(station: Station, seed: int) -> None:
    """Send a few hundred odd messages while time passes."""
    draw = random.Random(seed)
    for _ in range(300):
        station.send(odd_message(draw))
        station.run(0.1)


@pytest.mark.parametrize("seed", range(3))
def test_odd_messages_on_the_ground_and_in_the_air(seed: int) -> None:
    """Whatever fits the fields is answered or ignored; afterwards the copter still says where it is."""
    autopilot, station = sim()
    station.send(dialect.MAVLink_request_data_stream_message(1, 1, 0, 4, 1))
    bother(station, seed)
    autopilot, station = sim()
    station.fly()
    station.upload([item_at(100, 0), item_at(0, 100, command=82), item_at(0, 0)])
    station.mode(3)
    bother(station, 100 + seed)
    assert all(math.isfinite(part) for part in autopilot.flight.position_m)
    station.channel.request(dialect.MAVLINK_MSG_ID_GLOBAL_POSITION_INT)
    assert station.of("GLOBAL_POSITION_INT") != []


@pytest.mark.parametrize(
    ("name", "amount"),
    [("SYSID_THISMAV", 300), ("SIM_BATT_VOLTAGE", 1e6), ("BATT_CAPACITY", -5), ("SR0_EXTRA1", -3),
     ("SIM_WIND_SPD", 1e20), ("SERIAL0_PROTOCOL", 77)],
)  # fmt: skip
def test_odd_parameters(name: str, amount: float) -> None:
    """Telemetry goes on whatever these are set to."""
    autopilot, station = sim()
    autopilot.parameters.assign(name, amount)
    station.channel.restart()
    station.send(dialect.MAVLink_request_data_stream_message(0, 0, 0, 4, 1))
    station.run(12)
    assert len(station.of("SYS_STATUS")) > 20


@pytest.mark.parametrize("amount", [0.0, -1.0, 1e9, 1e-9])
def test_odd_flight_parameters(amount: float) -> None:
    """Set in the air, one after the other, to values that cannot be flown with, they break nothing."""
    autopilot, station = sim()
    station.fly(15)
    station.upload([item_at(20, 0, 15), item_at(20, 20, 18, command=82), item_at(0, 20, 15)])
    for name in (known for known in PARAMETERS if known in autopilot.parameters):
        before = autopilot.parameters[name]
        autopilot.parameters.assign(name, amount)
        for mode in (3, 6, 4, 9):
            station.mode(mode)
            station.run(1)
        autopilot.parameters.assign(name, before)
        station.channel.request(dialect.MAVLINK_MSG_ID_GLOBAL_POSITION_INT)
    assert all(math.isfinite(part) for part in autopilot.flight.position_m)
