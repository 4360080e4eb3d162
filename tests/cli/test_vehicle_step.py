"""vehicle_step.py: which vehicle is refused, and what is read of it."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from flight_replay.cli import vehicle_step
from flight_replay.cli.options import parse_options
from flight_replay.events import Event, Notice, ignore
from flight_replay.exceptions import VehicleError
from flight_replay.planning.drag import DragModel
from flight_replay.planning.vehicle_limits import VehicleLimits
from flight_replay.vehicle.identity import Identity


def vehicle(
    parameters: dict[str, float], *, simulated: bool = True, version: str = "4.6.0", maturity: int = 0
) -> Any:
    """A vehicle that has some parameters."""
    identity = Identity(1, 2, 3, version, takes_item_int=True, simulated=simulated, maturity=maturity)

    def read(names: Iterable[str]) -> dict[str, float]:
        return {name: parameters[name] for name in names if name in parameters}

    return SimpleNamespace(identity=identity, parameters=read)


def test_limits_are_read() -> None:
    """They are those of the vehicle with that name."""
    events: list[Event] = []
    limits = vehicle_step.vehicle_limits(vehicle({"WPNAV_SPEED": 300.0}), parse_options([]), events.append)
    assert limits.limits.wp_speed_m_s == 3.0
    assert limits.vehicle == "ArduCopter 4.6.0 (simulated quadcopter, system 1)"
    assert events == []


@pytest.mark.parametrize(
    ("version", "maturity", "late"),
    [("4.6.0", 0, False), ("4.6.0", 255, True), ("4.7.0", 0, True), ("", 0, False), ("4.5.7", 255, False)],
)
def test_corners_are_planned_for_as_the_firmware_flies_them(version: str, maturity: int, late: bool) -> None:
    """Which it is, the vehicle's version tells."""
    connected = vehicle({"WPNAV_SPEED": 1000.0}, version=version, maturity=maturity)
    limits = vehicle_step.vehicle_limits(connected, parse_options([]), ignore)
    assert bool(limits.limits.late_corners) is late


def test_a_vehicle_that_does_not_answer_is_planned_for_with_the_defaults() -> None:
    """With a warning."""
    events: list[Event] = []
    assert vehicle_step.vehicle_limits(vehicle({}), parse_options([]), events.append) == VehicleLimits()
    (warning,) = events
    assert isinstance(warning, Notice)
    assert warning.warning
    assert "defaults of ArduCopter 4.6" in warning.text


@pytest.mark.parametrize(
    ("version", "simulated", "mode", "turn_deg_s"),
    [
        ("4.6.0", True, "guided", 10.0),
        ("3.3.0", True, "guided", 60.0),
        ("3.3.0", False, "guided", 10.0),
        ("3.3.0", True, "auto", 10.0),
    ],
)
def test_headings_are_planned_with_the_turn_rate_that_is_flown(
    version: str, simulated: bool, mode: str, turn_deg_s: float
) -> None:
    """Where a simulated vehicle's is raised while it follows, with that."""
    own = {"WPNAV_SPEED": 1000.0, "ATC_SLEW_YAW": 1000.0}
    connected = vehicle(own, simulated=simulated, version=version)
    found = vehicle_step.vehicle_limits(connected, parse_options(["--mode", mode]), ignore)
    assert found.values["yaw_slew_deg_s"] == pytest.approx(turn_deg_s)


DRAG = {"EK3_DRAG_BCOEF_X": 12.0, "EK3_DRAG_BCOEF_Y": 10.0, "EK3_DRAG_MCOEF": 0.2}


@pytest.mark.parametrize(
    ("own", "simulated", "told"), [(DRAG, False, False), ({}, False, True), ({}, True, False)]
)
def test_drag_is_read_for_following(own: dict[str, float], simulated: bool, told: bool) -> None:
    """Whoever flies a real vehicle that does not tell it is told what is planned with."""
    events: list[Event] = []
    connected = vehicle({"WPNAV_SPEED": 1000.0, **own}, simulated=simulated)
    limits = vehicle_step.vehicle_limits(connected, parse_options(["--mode", "guided"]), events.append)
    assert limits.drag == (DragModel(10.0, 0.2) if own else None)
    assert [isinstance(event, Notice) and "EK3_DRAG_BCOEF_X" in event.text for event in events] == [
        True
    ] * told
    assert vehicle_step.vehicle_limits(connected, parse_options([]), events.append).drag is None


@pytest.mark.parametrize(
    "argv",
    [
        ["--connect", "x", "--speedup", "3"],
        ["--connect", "x", "--limits", "recorded"],
        ["--connect", "x", "--passes", "2", "--mode", "guided"],
    ],
)
def test_a_real_vehicle_is_refused_what_is_for_simulators(argv: list[str]) -> None:
    """Before anything is planned for it."""
    with pytest.raises(VehicleError, match=f"leave out {argv[2]}"):
        vehicle_step._check_options(vehicle({}, simulated=False), parse_options(argv))
    vehicle_step._check_options(vehicle({}), parse_options(argv))


def test_another_vehicle_than_a_multicopter_is_refused_before_the_plan() -> None:
    """A dry run plans with the limits that it has."""
    plane = vehicle({})
    plane.identity = replace(plane.identity, vehicle_type=1)
    with pytest.raises(VehicleError, match="fixed wing, system 1\\) is not a multicopter"):
        vehicle_step._check_options(plane, parse_options(["--connect", "x"]))
    vehicle_step._check_options(plane, parse_options(["--connect", "x", "--dry-run"]))


def test_the_signing_key_is_that_of_the_option(tmp_path: Path) -> None:
    """It is read before anything is connected to."""
    options = parse_options(["--connect", "tcp:127.0.0.1:1", "--signing-key", str(tmp_path / "key")])
    with (
        pytest.raises(VehicleError, match="cannot read the signing key"),
        vehicle_step.connected_vehicle("tcp:127.0.0.1:1", options, ignore, None),
    ):
        raise AssertionError
