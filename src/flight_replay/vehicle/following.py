"""What following needs of each firmware: how targets are tuned to it, and parameters for the flight.

Leads make up for what a controller adds to the delay of the link; they were measured in SITL, by flying
the same references with several leads. Firmware before 4.1 takes no acceleration with position and
velocity, and bounds targets by its speed and acceleration settings. 3.3 feeds forward how the velocity
that it wants changes, as far as its jerk limit lets the steps of targets through (AC_PosControl.cpp), and
stamps its positions with the time of its last GPS fix (GCS_Mavlink.cpp): a vehicle that is in step by
these stamps is a tenth of a second late.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from flight_replay.simulator.dynamics.limits import GRAVITY_M_S2
from flight_replay.supervisor.follower import Tuning
from flight_replay.vehicle.connected_vehicle import ConnectedVehicle
from flight_replay.vehicle.identity import Identity
from flight_replay.vehicle.protocol.motion_targets import TAKES_ACCELERATION

_WITHOUT_BRAKING = Tuning(braking_m_s2=0.0, braking_ahead_m=0.0, braking_slower_m_s=0.0)
"""Of 4.1, which pulls to a target that is ahead half as hard as those after it (control.cpp)."""
_WITHOUT_ACCELERATION = replace(
    _WITHOUT_BRAKING, position_s=-0.10, velocity_s=0.30, acceleration_s=0.0, heading_s=0.35
)
"""Of 3.4 to 4.0, where it was not flown."""
_OF_3_3 = Tuning(
    position_s=-0.15,
    velocity_s=-0.15,
    acceleration_s=0.0,
    heading_s=0.30,
    feed_forward=0.4,
    delay_s=0.25,
    drag_share=1.0,
    drag_per_s=GRAVITY_M_S2 / 15.0,  # Its terminal velocity is 15 m/s (SIM_Multicopter.cpp).
    braking_m_s2=0.0,
    braking_ahead_m=0.0,
    braking_slower_m_s=0.0,
)
_AFTER_3_3, _AFTER_4_1 = (3, 4), (4, 2)
TARGET_TIMEOUT_S = 0.5
"""Of ten targets a second four in a row may be lost before the vehicle stops."""
_RAISED_WITHOUT_ACCELERATION = {"WPNAV_SPEED": 1500.0, "WPNAV_ACCEL": 500.0, "ATC_SLEW_YAW": 6000.0}
"""cm/s, cm/s² and hundredths of degrees/s."""


def tuning_of(identity: Identity) -> Tuning:
    """How targets are tuned to a vehicle's firmware."""
    if identity.version_numbers >= TAKES_ACCELERATION:
        return Tuning() if identity.version_numbers >= _AFTER_4_1 else _WITHOUT_BRAKING
    return _WITHOUT_ACCELERATION if identity.version_numbers >= _AFTER_3_3 else _OF_3_3


def raised_for_following(identity: Identity) -> Mapping[str, float]:
    """The parameters of a simulated vehicle that are raised while it follows, in its own units."""
    old = identity.version_numbers < TAKES_ACCELERATION
    return _RAISED_WITHOUT_ACCELERATION if old and identity.simulated else {}


def parameters_for_following(connected: ConnectedVehicle) -> Mapping[str, float]:
    """Parameters to set while following, in the vehicle's own units.

    A vehicle whose targets stop coming brakes after ``GUID_TIMEOUT``, by itself only after 3 s; 3.3 has no
    such parameter. The limits of a simulated vehicle whose firmware bounds targets by them are raised.
    """
    wanted = {"GUID_TIMEOUT": TARGET_TIMEOUT_S}
    raised = raised_for_following(connected.identity)
    now = connected.parameters([*wanted, *raised])
    higher = {name: value for name, value in raised.items() if name in now and value > now[name]}
    return {name: value for name, value in wanted.items() if name in now} | higher
