"""How long a mission of 100 items takes on board over a bad link: this program, DroneKit and MAVProxy.

    python benchmarks/upload.py [RUNS]

All three talk to the same built-in copter through the same link (``tests/helpers/fault_link.py``) of frames
that get lost or are late, at speed 1. Ours ends when the mission was read back and compared; the others'
as soon as the copter says that it has received it, for they read nothing back. MAVProxy is left out
where it is not installed.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).parents[1]))

from flight_replay import vehicle
from flight_replay.exceptions import FlightReplayError
from flight_replay.mission import formats
from flight_replay.mission.items import Mission, waypoint
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.server import launch
from flight_replay.vehicle.dronekit_adapter import import_dronekit
from tests.helpers.fault_link import FaultLink, Message, Trigger, fault_link
from tests.helpers.link_conditions import LinkConditions

ITEMS = 100
LIMIT_S = 150.0
START_S = 8.0
MAVPROXY = Path(sys.executable).with_name("mavproxy.py")
MISSION = Mission(tuple(waypoint(47.397742 + 9e-5 * i, 8.545594, 30.0) for i in range(1, ITEMS + 1)))
CONDITIONS = {
    "clear": LinkConditions(),
    "20 % lost": LinkConditions(loss=0.2),
    "500 ms late": LinkConditions(delay_s=0.5),
    "20 % lost, 500 ms late": LinkConditions(loss=0.2, delay_s=0.5),
}


def tells_reception(message: Message) -> bool:
    return message.get_type() == "STATUSTEXT" and "light plan received" in message.text


@contextmanager
def link_to_copter(seed: int) -> Iterator[FaultLink]:
    """A copter behind a link that is clear so far; its trigger tells when a mission was received."""
    start = Start(47.397742, 8.545594, 488.0)
    triggers = (Trigger(tells_reception, lambda link: None),)
    with launch.run(start) as running, fault_link(running.connection, None, triggers, seed) as link:
        yield link


def ours(link: FaultLink, conditions: LinkConditions) -> float:
    """Seconds until the mission is on board and compared, or the limit."""
    with vehicle.connect(link.connection) as connected:
        link.conditions = conditions
        began_s = time.monotonic()
        connected.upload(MISSION)
        return time.monotonic() - began_s


def dronekits(link: FaultLink, conditions: LinkConditions) -> float:
    """Seconds of DroneKit's own clear and upload, after its download."""
    dronekit = import_dronekit()
    drone = dronekit.connect(link.connection, wait_ready=False)
    try:
        commands = drone.commands
        commands.download()
        time.sleep(1.0)
        commands.clear()
        for item in MISSION.items:
            place = (item.lat_deg, item.lon_deg, item.alt_m)
            commands.add(dronekit.Command(0, 0, 0, item.frame, item.command, 0, 0, *item.params, *place))
        link.conditions = conditions
        began_s = time.monotonic()
        commands.upload(timeout=LIMIT_S)
        return wait_received(link, began_s)
    finally:
        link.conditions = LinkConditions()
        drone.close()


def mavproxys(link: FaultLink, conditions: LinkConditions) -> float:
    """Seconds of MAVProxy's ``wp load``, once it has fetched the parameters."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mission.waypoints"
        formats.save(path, MISSION)
        process = subprocess.Popen(
            [sys.executable, str(MAVPROXY), "--master", link.connection, "--state-basedir", folder,
             "--aircraft", "test", "--default-modules", "wp,param"],
            cwd=folder, env={**os.environ, "HOME": folder, "TERM": "dumb"},
            stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        assert process.stdin
        try:
            time.sleep(START_S)
            link.conditions = conditions
            began_s = time.monotonic()
            process.stdin.write(f"wp load {path}\n")
            process.stdin.flush()
            return wait_received(link, began_s)
        finally:
            process.kill()
            process.wait()
            process.stdin.close()


def wait_received(link: FaultLink, began_s: float) -> float:
    while link.triggers[0].times and time.monotonic() - began_s < LIMIT_S:
        time.sleep(0.01)
    return time.monotonic() - began_s


def measured(
    upload: Callable[[FaultLink, LinkConditions], float], conditions: LinkConditions, runs: int
) -> str:
    """Median of several runs, and the failures among them."""
    times_s: list[float] = []
    failures = 0
    for seed in range(runs):
        with link_to_copter(seed) as link:
            try:
                times_s.append(upload(link, conditions))
            except (FlightReplayError, import_dronekit().APIException) as error:
                print(f"    {type(error).__name__}: {error}", file=sys.stderr)
                failures += 1
    failures += sum(seconds >= LIMIT_S for seconds in times_s)
    shown = f"{median(times_s):.1f} s" if times_s else "none"
    return shown + (f" ({failures} of {runs} failed)" if failures else "")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("runs", nargs="?", type=int, default=3)
    runs = parser.parse_args().runs
    peers: dict[str, Callable[[FaultLink, LinkConditions], float]] = {
        "flight-replay": ours,
        "DroneKit": dronekits,
    }
    if MAVPROXY.exists():
        peers["MAVProxy"] = mavproxys
    print(f"| link | {' | '.join(peers)} |\n| --- |{' --- |' * len(peers)}")
    for name, conditions in CONDITIONS.items():
        row = [measured(upload, conditions, runs) for upload in peers.values()]
        print(f"| {name} | {' | '.join(row)} |", flush=True)


if __name__ == "__main__":
    main()
