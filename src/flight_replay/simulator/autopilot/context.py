"""What the parts of the autopilot may ask of it, and what it reports to its observers.

The parts (arming, modes, failsafes, ...) know this interface, not the autopilot that joins them.
"""

from __future__ import annotations

from typing import Protocol

from flight_replay.events import Severity
from flight_replay.flight_modes import CopterMode
from flight_replay.simulator.autopilot.battery import Battery
from flight_replay.simulator.autopilot.commanded_copter import CommandedCopter
from flight_replay.simulator.autopilot.ekf_frame import EkfFrame
from flight_replay.simulator.autopilot.faults import Faults
from flight_replay.simulator.autopilot.location import HomeLocation
from flight_replay.simulator.autopilot.parameter_table import Parameters
from flight_replay.simulator.autopilot.sensors import Sensors
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.mission.store import MissionStore


class AutopilotContext(Protocol):
    """The state that the parts share, and what they may ask for."""

    faults: Faults
    parameters: Parameters
    store: MissionStore
    ekf_frame: EkfFrame
    sensors: Sensors
    battery: Battery
    flight: CommandedCopter
    home_is_locked: bool

    @property
    def time_s(self) -> float:
        """Seconds since boot, by the vehicle's clock."""

    @property
    def armed(self) -> bool:
        """Whether the motors are armed."""

    @property
    def mode(self) -> CopterMode:
        """The flight mode."""

    @property
    def home(self) -> HomeLocation | None:
        """Home, once the EKF has an origin."""

    def say(self, severity: Severity, text: str) -> None:
        """Send a status text to every station."""

    def set_home(self, position_m: Vector) -> None:
        """Make a position home."""

    def set_mode(self, mode: CopterMode) -> bool:
        """Enter a mode, as the pilot or the vehicle itself does; whether it was entered."""

    def disarm(self) -> None:
        """Stop the motors."""

    def reboot(self) -> None:
        """Boot again where the vehicle is."""

    def mode_entered(self) -> None:
        """Report that the mode has changed."""

    def item_reached(self, seq: int) -> None:
        """Report a mission item as reached."""

    def trigger(self, name: str) -> None:
        """Start what the fault script has for this trigger: "armed", "takeoff", a mode's name, ..."""


class AutopilotObserver(Protocol):
    """Receives what happens on board, when it happens."""

    def status_text(self, severity: Severity, text: str) -> None:
        """The vehicle sends a status text."""

    def home_changed(self) -> None:
        """Home was set, or moved."""

    def mode_changed(self) -> None:
        """Another flight mode was entered."""

    def item_reached(self, seq: int) -> None:
        """A mission item was reached."""

    def rebooted(self) -> None:
        """The vehicle booted again: transfers under way are lost."""
