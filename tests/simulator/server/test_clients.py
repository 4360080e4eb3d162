"""Other people's programs against the built-in copter: DroneKit's stock behaviour, MAVProxy."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from flight_replay.simulator.server.launch import run
from tests.helpers.mavproxy import ARMED_ON_GROUND, DEADLINE_S, MavProxy
from tests.helpers.sim_station import START

SPEEDUP = 20


def wait(condition: Callable[[], object], wall_s: float = DEADLINE_S) -> None:
    """Wait for something that must happen."""
    deadline = time.monotonic() + wall_s
    while not condition():
        assert time.monotonic() < deadline, "it did not happen"
        time.sleep(0.01)


@contextmanager
def dronekit_vehicle(connection: str) -> Iterator[tuple[Any, Any]]:
    """DroneKit itself and a vehicle of its stock connect()."""
    from flight_replay.vehicle.dronekit_adapter import import_dronekit

    dronekit = import_dronekit()
    vehicle = dronekit.connect(connection, wait_ready=True, heartbeat_timeout=DEADLINE_S, timeout=DEADLINE_S)
    try:
        yield dronekit, vehicle
    finally:
        vehicle.close()


def test_dronekits_stock_behaviour_works() -> None:
    """connect(wait_ready=True), download(), simple_takeoff, simple_goto, upload, AUTO and RTL, as ever."""
    with (
        run(START, speedup=SPEEDUP, parameters=ARMED_ON_GROUND) as running,
        dronekit_vehicle(running.connection) as (dronekit, vehicle),
    ):
        assert vehicle.version.major == 4
        assert vehicle.parameters["WPNAV_SPEED"] == 1000
        wait(lambda: vehicle.is_armable)
        vehicle.commands.download()
        vehicle.commands.wait_ready(timeout=DEADLINE_S)
        assert vehicle.home_location.lat == pytest.approx(START.lat_deg, abs=1e-5)
        vehicle.mode = dronekit.VehicleMode("GUIDED")
        vehicle.armed = True
        wait(lambda: vehicle.armed)
        vehicle.simple_takeoff(20)
        wait(lambda: vehicle.location.global_relative_frame.alt > 19)
        there = START.location_of((30.0, 0.0, 0.0))
        target = dronekit.LocationGlobalRelative(there.lat_e7 / 1e7, there.lon_e7 / 1e7, 20)
        vehicle.simple_goto(target)
        wait(lambda: abs(vehicle.location.global_relative_frame.lat - target.lat) < 1e-5)
        for _ in range(3):
            vehicle.commands.add(
                dronekit.Command(0, 0, 0, 3, 16, 0, 0, 0, 0, 0, 0, START.lat_deg, START.lon_deg, 25)
            )
        vehicle.commands.upload(timeout=DEADLINE_S)
        vehicle.mode = dronekit.VehicleMode("AUTO")
        wait(lambda: vehicle.commands.next == 3)
        vehicle.mode = dronekit.VehicleMode("RTL")
        wait(lambda: not vehicle.armed)
        assert math.hypot(vehicle.location.local_frame.north, vehicle.location.local_frame.east) < 1


MISSION = f"""QGC WPL 110
0	1	0	16	0	0	0	0	{START.lat_deg}	{START.lon_deg}	488	1
1	0	3	22	0	0	0	0	0	0	15	1
2	0	3	16	0	0	0	0	{START.lat_deg + 4e-4}	{START.lon_deg}	15	1
3	0	3	82	0	0	0	0	{START.lat_deg + 4e-4}	{START.lon_deg + 4e-4}	20	1
4	0	3	16	0	0	0	0	{START.lat_deg}	{START.lon_deg + 4e-4}	15	1
"""


@pytest.mark.mavproxy
def test_mavproxy_flies_a_mission(tmp_path: Path) -> None:
    """It loads a .waypoints file, arms, takes off, flies the mission in AUTO and comes home in RTL."""
    pytest.importorskip("MAVProxy")
    (tmp_path / "mission.waypoints").write_text(MISSION, encoding="ascii")
    # At speed 1 at first: the vehicle gives up an upload after 8 s of its own.
    with run(START, parameters=ARMED_ON_GROUND) as running:
        station = MavProxy(running.connection, tmp_path)
        try:
            station.expect("Received 1340 parameters")
            station.command("wp load mission.waypoints", "Flight plan received")
            station.say("param set SIM_SPEEDUP 10")
            station.command("mode guided", "Mode GUIDED")
            station.command("arm throttle", "ARMED")
            station.command("takeoff 15", "NAV_TAKEOFF: ACCEPTED")
            station.command("mode auto", "Mode AUTO")
            station.expect("Mission: 1 Takeoff", "Mission: 2 WP", "Mission: 3 SplineWP", "Mission: 4 WP")
            station.expect("Reached command #4")
            station.command("mode rtl", "Mode RTL")
            station.expect("DISARMED")
        finally:
            station.close()
