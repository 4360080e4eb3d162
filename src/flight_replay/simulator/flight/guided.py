"""GUIDED: flying at a velocity, and to a position (ArduCopter/mode_guided.cpp)."""

from __future__ import annotations

from math import hypot

from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.flight_control import FlightControl


class GuidedVelocity:
    """Fly at ``velocity_m_s``, north, east, up, at most WPNAV_ACCEL (ModeGuided::velaccel_control_run)."""

    done = False

    def __init__(self, flight: FlightControl, velocity_m_s: Vector) -> None:
        self._flight = flight
        self.velocity_m_s = velocity_m_s
        flight.auto_yaw.set_default_mode()

    def step(self) -> None:
        """Move the target, and the copter after it."""
        flight, control = self._flight, self._flight.control
        control.update()
        self._move_target()
        control.input_climb_rate(self.velocity_m_s[2])
        flight.auto_yaw.update()

    def _move_target(self) -> None:
        control = self._flight.control
        dt = control.dt
        dn, de = self.velocity_m_s[0] - control.vn, self.velocity_m_s[1] - control.ve
        size = hypot(dn, de)
        share = min(1.0, control.accel_max * dt / size) if size > 0 else 0.0
        control.accel_n, control.accel_e = dn * share / dt, de * share / dt
        control.vn, control.ve = control.vn + dn * share, control.ve + de * share
        control.n, control.e = control.n + control.vn * dt, control.e + control.ve * dt


class GuidedPosition:
    """Fly to a position (ModeGuided::pos_control_run, AC_PosControl::input_pos_xyz)."""

    def __init__(self, flight: FlightControl, position: Vector) -> None:
        self._flight = flight
        self.position = position
        self.done = False
        flight.auto_yaw.set_default_mode()

    def step(self) -> None:
        """Move the target, and the copter after it."""
        flight = self._flight
        flight.control.update()
        flight.control.input_position(self.position)
        flight.auto_yaw.update()
        n, e, u = self.position
        airframe = flight.airframe
        self.done = hypot(airframe.n - n, airframe.e - e, airframe.u - u) <= flight.limits.wp_radius_m
