"""Flying at a velocity, as GUIDED does (ModeGuided::velaccel_control_run)."""

from __future__ import annotations

from math import hypot

from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.phase import Flight


class Drift:
    """Bring the target to ``velocity_m_s``, north, east, up, with the waypoint acceleration."""

    done = False

    def __init__(self, flight: Flight, velocity_m_s: Vector) -> None:
        self._flight = flight
        self.velocity_m_s = velocity_m_s
        flight.heading.use_default()

    def step(self) -> None:
        """Move the target at the velocity that it has by now, and the copter after it."""
        flight, control = self._flight, self._flight.control
        control.update()
        self._move_target()
        control.shape_climb(self.velocity_m_s[2])
        flight.heading.update()

    def _move_target(self) -> None:
        control = self._flight.control
        dt = control.dt
        dn, de = self.velocity_m_s[0] - control.vn, self.velocity_m_s[1] - control.ve
        size = hypot(dn, de)
        part = min(1.0, control.accel_max * dt / size) if size > 0 else 0.0
        control.accel_n, control.accel_e = dn * part / dt, de * part / dt
        control.vn, control.ve = control.vn + dn * part, control.ve + de * part
        control.n, control.e = control.n + control.vn * dt, control.e + control.ve * dt


class GoTo:
    """Fly to a place (ModeGuided::pos_control_run, AC_PosControl::input_pos_xyz)."""

    def __init__(self, flight: Flight, place: Vector) -> None:
        self._flight = flight
        self.place = place
        self.done = False
        flight.heading.use_default()

    def step(self) -> None:
        """Move the target towards the place, and the copter after it."""
        flight = self._flight
        flight.control.update()
        flight.control.shape_to(self.place)
        flight.heading.update()
        n, e, u = self.place
        body = flight.body
        self.done = hypot(body.n - n, body.e - e, body.u - u) <= flight.limits.wp_radius_m
