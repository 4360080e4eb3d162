"""What following needs of each firmware."""

from __future__ import annotations

from collections.abc import Iterable
from types import SimpleNamespace

import pytest

from flight_replay.supervisor.follower import Tuning
from flight_replay.vehicle.following import parameters_for_following, tuning_of
from flight_replay.vehicle.identity import Identity

OWN = {"GUID_TIMEOUT": 3.0, "WPNAV_SPEED": 500.0, "WPNAV_ACCEL": 800.0, "ATC_SLEW_YAW": 1000.0}


def _parameters(version: str, *, simulated: bool, own: dict[str, float]) -> dict[str, float]:
    def known(names: Iterable[str]) -> dict[str, float]:
        return {name: own[name] for name in names if name in own}

    identity = Identity(1, 2, 3, version, takes_item_int=True, simulated=simulated)
    return dict(parameters_for_following(SimpleNamespace(identity=identity, parameters=known)))  # type: ignore[arg-type]


@pytest.mark.parametrize("simulated", [True, False])
def test_a_vehicle_brakes_soon_when_targets_stop(simulated: bool) -> None:
    assert _parameters("4.6.0", simulated=simulated, own=OWN) == {"GUID_TIMEOUT": 0.5}


def test_only_simulated_vehicles_with_old_firmware_get_higher_limits() -> None:
    own = {name: value for name, value in OWN.items() if name != "GUID_TIMEOUT"}
    raised = {"WPNAV_SPEED": 1500.0, "ATC_SLEW_YAW": 6000.0}
    assert _parameters("3.3.0", simulated=True, own=own) == raised
    assert _parameters("3.3.0", simulated=False, own=own) == {}


def test_tuning_is_the_firmwares() -> None:
    def of(version: str) -> Tuning:
        return tuning_of(Identity(1, 2, 3, version, takes_item_int=True, simulated=True))

    assert of("4.6.0") == of("4.2.0") == Tuning()
    assert of("4.1.0") == Tuning(braking_m_s2=0.0, braking_ahead_m=0.0, braking_slower_m_s=0.0)
    assert of("4.0.7") == of("3.4.0") != Tuning()
    assert of("3.3.2").feed_forward < 1.0
