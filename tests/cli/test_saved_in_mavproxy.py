"""A mission of --save in MAVProxy as docs/files.md has it: loaded, armed, flown from take-off to RTL."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

import pytest

from flight_replay.cli.main import main
from flight_replay.flight_modes import CopterMode
from flight_replay.logs.read_log import read_log
from flight_replay.mission import formats
from flight_replay.output.comparison import compare_tracks, part_in
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.server import launch
from flight_replay.vehicle.sitl import simulator
from tests.helpers.mavproxy import MavProxy
from tests.helpers.paths import SAMPLE

PART = ["--from", "85", "--to", "125"]
NEAR_M = 3.0


@contextmanager
def builtin(start: Start) -> Iterator[str]:
    with launch.run(start) as running:
        yield running.connection


@contextmanager
def sitl(start: Start) -> Iterator[str]:
    with simulator("sitl", None, start) as connection:
        yield connection


COPTERS = [
    pytest.param(builtin, marks=pytest.mark.mavproxy),
    pytest.param(
        sitl,
        marks=[
            pytest.mark.sitl,
            pytest.mark.skipif("SITL_BINARY" not in os.environ, reason="SITL_BINARY names no ArduCopter"),
        ],
    ),
]


@pytest.mark.parametrize("copter", COPTERS)
def test_mavproxy_loads_arms_and_flies_a_saved_mission(
    copter: Callable[[Start], AbstractContextManager[str]], tmp_path: Path
) -> None:
    """Along the recording, and home."""
    pytest.importorskip("MAVProxy")
    saved = tmp_path / "saved.waypoints"
    assert main(["--tlog", str(SAMPLE), *PART, "--dry-run", "-q", "--save", str(saved)]) == 0
    mission = formats.load_mission(saved)
    home = mission.home
    assert home is not None
    # At speed 1 at first: the vehicle gives up an upload after 8 s of its own.
    with copter(Start(home.lat_deg, home.lon_deg, home.amsl_m, 0.0)) as connection:
        station = MavProxy(connection, tmp_path)
        try:
            station.expect(r"Received \d+ parameters")
            station.command("wp load saved.waypoints", "Flight plan received")
            for parameter in ("DISARM_DELAY 0", "SIM_SPEEDUP 10"):
                station.say(f"param set {parameter}")
            station.command("mode guided", "Mode GUIDED")
            station.command("arm throttle", "ARMED")
            station.command("mode auto", "Mode AUTO")
            station.command("long MISSION_START", "MISSION_START: ACCEPTED")
            station.expect("Mission: 1 Takeoff", rf"Mission: {len(mission.items)} RTL", "DISARMED")
        finally:
            station.close()
    (log,) = tmp_path.rglob("*.tlog")
    flown, _ = part_in(read_log(log), [CopterMode.AUTO])
    recorded = read_log(SAMPLE).track
    since_s = recorded.time_s - recorded.time_s[0]
    compared = compare_tracks(recorded.select((since_s >= 85) & (since_s <= 125)), flown)
    path = compared.errors.path_m
    assert max(*path.recorded_to_path.error, *path.path_to_recorded.error) < NEAR_M
