"""vehicle_step.py: which vehicle is refused, and what is read of it."""

from types import SimpleNamespace
from typing import Any

import pytest

from flight_replay.cli import vehicle_step
from flight_replay.cli.options import parse_options
from flight_replay.errors import VehicleError
from flight_replay.events import Event, Notice
from flight_replay.planning.vehicle_limits import PARAMETER_NAMES, VehicleLimits
from flight_replay.vehicle.identity import Identity


def vehicle(parameters: dict[str, float], *, simulated: bool = True) -> Any:
    """A vehicle that has some parameters."""
    identity = Identity(1, 1, 2, 3, "4.6.0", takes_item_int=True, simulated=simulated)
    known = {name: value for name, value in parameters.items() if name in PARAMETER_NAMES}
    return SimpleNamespace(identity=identity, parameters=lambda names: known)


def test_limits_are_read() -> None:
    """They are those of the vehicle with that name."""
    events: list[Event] = []
    limits = vehicle_step.vehicle_limits(vehicle({"WPNAV_SPEED": 300.0}), events.append)
    assert limits.limits.wp_speed_m_s == 3.0
    assert limits.vehicle == "ArduCopter 4.6.0 (simulated quadcopter, system 1)"
    assert events == []


def test_a_vehicle_that_does_not_answer_is_planned_for_with_the_defaults() -> None:
    """With a warning."""
    events: list[Event] = []
    assert vehicle_step.vehicle_limits(vehicle({}), events.append) == VehicleLimits()
    (warning,) = events
    assert isinstance(warning, Notice)
    assert warning.warning
    assert "defaults of ArduCopter 4.6" in warning.text


@pytest.mark.parametrize(
    "argv", [["--connect", "x", "--speedup", "3"], ["--connect", "x", "--limits", "recorded"]]
)
def test_a_real_vehicle_is_refused_what_is_for_simulators(argv: list[str]) -> None:
    """Before anything is planned for it."""
    with pytest.raises(VehicleError, match=f"leave out {argv[2]}"):
        vehicle_step._check_options(vehicle({}, simulated=False), parse_options(argv))
    vehicle_step._check_options(vehicle({}), parse_options(argv))
