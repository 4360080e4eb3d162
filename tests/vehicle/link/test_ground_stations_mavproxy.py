"""MAVProxy beside a replay: it watches and takes over through --gcs, and flies the missions we save."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from flight_replay.logs.read_log import read_log
from flight_replay.mission import formats
from flight_replay.mission.items import Home, Mission, change_speed, waypoint
from flight_replay.simulator.server.launch import run
from tests.helpers.machine import free_udp_port
from tests.helpers.mavproxy import ARMED_ON_GROUND, DEADLINE_S, MavProxy
from tests.helpers.paths import SAMPLE
from tests.helpers.sim_station import START

pytestmark = pytest.mark.mavproxy


def test_a_station_watches_the_whole_replay_and_may_take_over(tmp_path: Path) -> None:
    """MAVProxy hears the vehicle from connecting on, fetches the parameters, and its LOITER counts."""
    pytest.importorskip("MAVProxy")
    port = free_udp_port()
    station = MavProxy(f"udpin:127.0.0.1:{port}", tmp_path)
    station.expect("Waiting for heartbeat")
    options = ["--tlog", str(SAMPLE), "--sim", "builtin", "--speedup", "5", "--duration", "all"]
    options += ["--gcs", f"udpout:127.0.0.1:{port}"]
    with subprocess.Popen(
        [sys.executable, "-m", "flight_replay", *options],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as replay:
        try:
            # Not by what is said once: a busy station loses datagrams.
            station.expect("Detected vehicle", "ARMED", "Received 1340 parameters", r"Reached command #\d")
            station.command("mode LOITER", "LOITER>")
            _, errors = replay.communicate(timeout=DEADLINE_S)
        finally:
            replay.kill()
            station.close()
    assert replay.returncode == 1
    assert "the mode was changed to LOITER by the pilot" in errors
    (recorded,) = tmp_path.rglob("*.tlog")
    log = read_log(recorded)
    assert log.track.alt_m.max() > 25
    assert log.vehicle is not None
    assert log.vehicle.system == 1


def test_mavproxy_loads_and_flies_a_saved_mission(tmp_path: Path) -> None:
    """``wp load`` of our .waypoints, flown in AUTO, saved again: every place within a centimetre."""
    pytest.importorskip("MAVProxy")
    places = [(2e-4, 0.0), (2e-4, 3e-4), (0.0, 3e-4)]
    items = [
        waypoint(START.lat_deg + north, START.lon_deg + east, 20.0 + n, spline=n == 1)
        for n, (north, east) in enumerate(places)
    ]
    mission = Mission((items[0], change_speed(4.0), *items[1:]), Home(START.lat_deg, START.lon_deg, 488.0))
    formats.save(tmp_path / "saved.waypoints", mission)
    # At speed 1 at first: the vehicle gives up an upload after 8 s of its own.
    with run(START, parameters=ARMED_ON_GROUND) as running:
        station = MavProxy(running.connection, tmp_path)
        try:
            station.expect("Received 1340 parameters")
            station.command("wp load saved.waypoints", "Flight plan received")
            station.command("wp save back.waypoints", "Saved 5 waypoints")
            station.say("param set SIM_SPEEDUP 10")
            station.command("mode guided", "Mode GUIDED")
            station.command("arm throttle", "ARMED")
            station.command("takeoff 20", "NAV_TAKEOFF: ACCEPTED")
            station.command("status GLOBAL_POSITION_INT", r"relative_alt : (1[5-9]|2\d)\d{3}\b")
            station.command("mode auto", "Mode AUTO")
            station.expect("Reached command #4")
        finally:
            station.close()
    back = formats.load_mission(tmp_path / "back.waypoints")
    assert [item.command for item in back.items] == [item.command for item in mission.items]
    for was, now in zip(mission.items, back.items, strict=True):
        assert (now.lat_deg, now.lon_deg) == pytest.approx((was.lat_deg, was.lon_deg), abs=1e-6)
        assert (now.alt_m, now.params) == (was.alt_m, was.params)
