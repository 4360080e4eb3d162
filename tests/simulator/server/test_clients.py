"""Other people's programs against the built-in copter: DroneKit's stock behaviour, MAVProxy."""

from __future__ import annotations

import contextlib
import math
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from flight_replay.simulator.server.launch import run
from tests.helpers.sim_station import START

SPEEDUP = 20


def wait(condition: Callable[[], object], wall_s: float = 60.0) -> None:
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
    vehicle = dronekit.connect(connection, wait_ready=True)
    try:
        yield dronekit, vehicle
    finally:
        vehicle.close()


def test_dronekits_stock_behaviour_works() -> None:
    """connect(wait_ready=True), download(), simple_takeoff, simple_goto, upload, AUTO and RTL, as ever."""
    with run(START, speedup=SPEEDUP) as running, dronekit_vehicle(running.connection) as (dronekit, vehicle):
        assert vehicle.version.major == 4
        assert vehicle.parameters["WPNAV_SPEED"] == 1000
        wait(lambda: vehicle.is_armable)
        vehicle.commands.download()
        vehicle.commands.wait_ready(timeout=10)
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
        vehicle.commands.upload(timeout=10)
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


class Console:
    """MAVProxy at its prompt: lines in, lines out."""

    def __init__(self, connection: str, folder: Path) -> None:
        script = Path(sys.executable).with_name("mavproxy.py")
        self._process = subprocess.Popen(
            [sys.executable, str(script), "--master", connection, "--state-basedir", str(folder),
             "--aircraft", "test", "--default-modules", "arm,cmdlong,mode,wp,param"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            cwd=folder, env={**os.environ, "HOME": str(folder), "TERM": "dumb"},
        )  # fmt: skip
        self._lines: list[str] = []
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        self._lines.extend(self._process.stdout)

    def say(self, command: str) -> None:
        """Type a line."""
        assert self._process.stdin is not None
        self._process.stdin.write(command + "\n")
        self._process.stdin.flush()

    def expect(self, text: str, limit_s: float = 60.0) -> None:
        """Wait for a line with a text, and forget what came before it."""

        def find() -> bool:
            return any(text in line for line in self._lines)

        try:
            wait(find, limit_s)
        except AssertionError:
            raise AssertionError(f"no '{text}' in {self._lines}") from None
        index = next(i for i, line in enumerate(self._lines) if text in line)
        del self._lines[: index + 1]

    def insist(self, command: str, text: str) -> None:
        """Type a line every two seconds until a text comes: the copter may not be ready at first."""
        for _ in range(30):
            self.say(command)
            with contextlib.suppress(AssertionError):
                return self.expect(text, 2.0)
        raise AssertionError(f"no '{text}' after '{command}' in {self._lines}")

    def close(self) -> None:
        """End MAVProxy."""
        self._process.kill()
        self._process.wait()
        self._reader.join()
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.close()
        self._process.stdout.close()


@pytest.mark.mavproxy
def test_mavproxy_flies_a_mission(tmp_path: Path) -> None:
    """It loads a .waypoints file, arms, takes off, flies the mission in AUTO and comes home in RTL."""
    pytest.importorskip("MAVProxy")
    (tmp_path / "mission.waypoints").write_text(MISSION, encoding="ascii")
    with run(START, speedup=10) as running:
        console = Console(running.connection, tmp_path)
        try:
            console.expect("Received 1340 parameters")
            console.say("wp load mission.waypoints")
            console.expect("Flight plan received")
            console.say("mode guided")
            console.expect("Mode GUIDED")
            console.insist("arm throttle", "ARMED")
            console.say("takeoff 15")
            console.expect("NAV_TAKEOFF: ACCEPTED")
            console.say("mode auto")
            for seq, name in ((1, "Takeoff"), (2, "WP"), (3, "SplineWP"), (4, "WP")):
                console.expect(f"Mission: {seq} {name}")
            console.expect("Reached command #4")
            console.say("mode rtl")
            console.expect("Mode RTL")
            console.expect("DISARMED")
        finally:
            console.close()
