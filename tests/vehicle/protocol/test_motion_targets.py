"""Targets in the form that each firmware takes."""

from __future__ import annotations

import math

import pytest

from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.mavlink import Message, dialect
from flight_replay.supervisor.vehicle_interface import Target
from flight_replay.vehicle.protocol.motion_targets import MotionTargets

ORIGIN = FlatFrame(47.0, 8.0)


class _Link:
    system, component = 1, 1

    def __init__(self) -> None:
        self.sent: list[Message] = []

    def send(self, message: Message) -> None:
        self.sent.append(message)


def _targets(version: tuple[int, ...], speed_m_s: float = 0.0) -> tuple[MotionTargets, _Link]:
    """Targets for a vehicle 30 m north of its origin, whose home is 3 m above that."""
    link = _Link()
    targets = MotionTargets(link, version)  # type: ignore[arg-type]
    lat_deg, lon_deg = ORIGIN.to_degrees((30.0, 0.0))
    for message in (
        dialect.MAVLink_global_position_int_message(
            1000, round(float(lat_deg) * 1e7), round(float(lon_deg) * 1e7), 423000, 20000, 0, 0, 0, 0
        ),
        dialect.MAVLink_local_position_ned_message(1002, 30.0, 0.0, -23.0, speed_m_s, 0.0, 0.0),
    ):
        targets.origin.receive(message)
    return targets, link


def _target(heading_deg: float | None = 90.0) -> Target:
    lat_deg, lon_deg = ORIGIN.to_degrees((10.0, -5.0))
    return Target(float(lat_deg), float(lon_deg), 25.0, (1.0, 2.0, 3.0), (0.1, 0.2, 0.3), heading_deg, 10.0)


def test_all_five_quantities_around_the_ekfs_origin() -> None:
    targets, link = _targets((4, 6, 0))
    targets.send(_target())
    (message,) = link.sent
    assert (message.coordinate_frame, message.type_mask) == (dialect.MAV_FRAME_LOCAL_NED, 0)
    assert (message.x, message.y, message.z) == pytest.approx((10.0, -5.0, -28.0), abs=0.02)
    assert (message.vx, message.vy, message.vz) == (1.0, 2.0, -3.0)
    assert (message.afx, message.afy, message.afz) == (0.1, 0.2, -0.3)
    assert message.yaw == pytest.approx(math.pi / 2)
    assert message.yaw_rate == pytest.approx(math.radians(10.0))


def test_a_home_that_is_moved_in_flight_does_not_move_the_targets() -> None:
    targets, link = _targets((4, 6, 0))
    targets.send(_target())
    moved = dialect.MAVLink_global_position_int_message(2000, 470000000, 80000000, 423000, 3000, 0, 0, 0, 0)
    targets.origin.receive(moved)
    targets.send(_target())
    first, second = link.sent
    assert second.z == first.z


def test_a_heading_of_its_own_is_masked() -> None:
    targets, link = _targets((4, 6, 0))
    targets.send(_target(None))
    assert link.sent[0].type_mask == 0b110000000000


def test_firmware_before_4_1_gets_no_acceleration() -> None:
    targets, link = _targets((4, 0, 7))
    targets.send(_target())
    assert link.sent[0].type_mask == 0b111000000


def test_3_3_turns_by_condition_yaw() -> None:
    targets, link = _targets((3, 3, 0))
    for _ in range(4):
        targets.send(_target())
    kinds = [message.get_type() for message in link.sent]
    assert kinds.count("COMMAND_LONG") == 2
    yaw = next(message for message in link.sent if message.get_type() == "COMMAND_LONG")
    assert (yaw.command, yaw.param1) == (dialect.MAV_CMD_CONDITION_YAW, 90.0)
    assert link.sent[0].type_mask == 0b110111000000


def test_the_origin_is_taken_only_at_rest() -> None:
    assert _targets((4, 6, 0))[0].origin.known
    assert not _targets((4, 6, 0), speed_m_s=3.0)[0].origin.known


def test_a_place_to_fly_to_is_global() -> None:
    targets, link = _targets((4, 6, 0))
    targets.send_position(47.1, 8.1, 30.0)
    (message,) = link.sent
    assert message.get_type() == "SET_POSITION_TARGET_GLOBAL_INT"
    assert (message.lat_int, message.lon_int, message.alt) == (471000000, 81000000, 30.0)
    assert message.type_mask == 0b110111111000
