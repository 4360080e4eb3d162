"""What following needs of each firmware: how far ahead targets are taken, and parameters for the flight.

Leads make up for what a controller adds to the delay of the link; they were measured in SITL, by flying
the same references with several leads. Firmware before 4.1 takes no acceleration with position and
velocity, and bounds targets by its speed and acceleration settings.
"""

from __future__ import annotations

from collections.abc import Mapping

from flight_replay.supervisor.follower import Leads
from flight_replay.vehicle.connected_vehicle import ConnectedVehicle
from flight_replay.vehicle.identity import Identity
from flight_replay.vehicle.protocol.motion_targets import TAKES_ACCELERATION

_LEADS_WITHOUT_ACCELERATION = Leads(position_s=-0.10, velocity_s=0.30, acceleration_s=0.0, heading_s=0.35)
TARGET_TIMEOUT_S = 0.5
_RAISED_WITHOUT_ACCELERATION = {"WPNAV_SPEED": 1500.0, "WPNAV_ACCEL": 500.0, "ATC_SLEW_YAW": 6000.0}
"""cm/s, cm/s² and hundredths of degrees/s."""


def leads(identity: Identity) -> Leads:
    """How far ahead of the vehicle's time each quantity of a target is taken."""
    return Leads() if identity.version_numbers >= TAKES_ACCELERATION else _LEADS_WITHOUT_ACCELERATION


def parameters_for_following(connected: ConnectedVehicle) -> Mapping[str, float]:
    """Parameters to set while following, in the vehicle's own units.

    A vehicle whose targets stop coming brakes after ``GUID_TIMEOUT``, by itself only after 3 s; 3.3 has no
    such parameter. The limits of a simulated vehicle whose firmware bounds targets by them are raised.
    """
    wanted = {"GUID_TIMEOUT": TARGET_TIMEOUT_S}
    old = connected.identity.version_numbers < TAKES_ACCELERATION
    raised = _RAISED_WITHOUT_ACCELERATION if old and connected.identity.simulated else {}
    now = connected.parameters([*wanted, *raised])
    higher = {name: value for name, value in raised.items() if name in now and value > now[name]}
    return {name: value for name, value in wanted.items() if name in now} | higher
