"""How long does a mission take, and how close does the copter pass its waypoints? Only simulated.

    python examples/simulate_mission.py [MISSION.waypoints [NAME=VALUE ...]]

NAME=VALUE are ArduPilot parameters, in ArduPilot's units, such as WPNAV_SPEED=500. Without arguments,
a square of 40 m is flown.
"""

import sys

import numpy as np

from flight_replay.exceptions import FlightReplayError, MissionError
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.mission.formats import load_mission
from flight_replay.mission.items import Home, Mission, waypoint
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.trajectory import home_frame, simulate, simulate_flight


def square() -> Mission:
    home = Home(47.397742, 8.545594, 488.0)
    lat, lon = LocalFrame(home.lat_deg, home.lon_deg).to_degrees([(40, 0), (40, 40), (0, 40), (0, 0)])
    return Mission(tuple(waypoint(a, b, 20.0) for a, b in zip(lat, lon, strict=True)), home)


def parameter(argument: str) -> tuple[str, float]:
    name, _, value = argument.partition("=")
    try:
        return name, float(value)
    except ValueError:
        raise MissionError(f"{argument} is no parameter; give NAME=VALUE, such as WPNAV_SPEED=500") from None


def main() -> None:
    mission = load_mission(sys.argv[1]) if len(sys.argv) > 1 else square()
    limits = Limits.from_parameters(dict(map(parameter, sys.argv[2:])))

    flown = simulate(mission, limits)
    frame = home_frame(mission)
    for seq, item in mission.waypoints:
        place = frame.to_metres(item.lat_deg, item.lon_deg)
        nearest = np.linalg.norm(flown.north_east_m - place, axis=1).min()
        print(f"item {seq} reached after {flown.reached_s[seq]:6.2f} s, passed at {nearest:.2f} m")
    begin_s, end_s = flown.auto_s
    speed = np.hypot(flown.north_m_s, flown.east_m_s).max()
    print(f"AUTO takes {end_s - begin_s:.1f} s, at up to {speed:.1f} m/s")
    if mission.home is not None:
        print(f"from arming to disarming: {simulate_flight(mission, limits).time_s[-1]:.1f} s")


if __name__ == "__main__":
    try:
        main()
    except FlightReplayError as error:
        sys.exit(str(error))
