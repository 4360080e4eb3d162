"""Parameters are read one by one, set with confirmation, and restored."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from flight_replay.exceptions import VehicleError
from flight_replay.mavlink import Message
from flight_replay.simulator.autopilot.faults import old_copter
from flight_replay.vehicle.identity import identify
from flight_replay.vehicle.link.discovery import DiscoveredVehicle
from flight_replay.vehicle.link.round_trip import RoundTrip
from flight_replay.vehicle.protocol.parameters import (
    limits_as_parameters,
    parameters_set,
    read_parameters,
    set_parameters,
    write_parameters,
)
from tests.helpers.link_conditions import LinkConditions
from tests.helpers.virtual_link import VirtualLink

NAMES = ["WPNAV_SPEED", "RTL_ALT", "FENCE_ENABLE", "SIM_SPEEDUP"]


@pytest.mark.parametrize("loss", [0.0, 0.2, 0.4])
@pytest.mark.parametrize("seed", range(5))
def test_values_are_read_over_a_link_that_loses_packets(loss: float, seed: int) -> None:
    """Every parameter that the vehicle has is read, however many requests get lost."""
    link = VirtualLink(LinkConditions(loss=loss), seed=seed, WPNAV_SPEED=777.0)
    values = read_parameters(link, NAMES)
    assert values.keys() == set(NAMES)
    assert values["WPNAV_SPEED"] == 777.0


def test_a_name_that_the_vehicle_does_not_have_costs_little() -> None:
    """No answer for one name while others are answered counts as unknown soon."""
    link = VirtualLink()
    assert read_parameters(link, [*NAMES, "NO_SUCH_NAME"]).keys() == set(NAMES)
    assert link.now_s() < 1.0


def test_the_answer_to_one_name_tells_how_long_to_wait_for_another() -> None:
    """ArduCopter 3.3 does not reply to TIMESYNC."""
    link = VirtualLink(faults=old_copter())
    link.round_trip = RoundTrip()
    assert read_parameters(link, ["WPNAV_SPEED", "NO_SUCH_NAME"]).keys() == {"WPNAV_SPEED"}
    assert link.now_s() < 2.0


def test_reading_ends_at_its_limit() -> None:
    """Without any answer nothing is known, and the wait ends."""
    link = VirtualLink(LinkConditions(loss=1.0))
    assert read_parameters(link, NAMES, limit_s=3.0) == {}
    assert link.now_s() < 4


@pytest.mark.parametrize("loss", [0.0, 0.4])
def test_values_are_set_and_restored(loss: float) -> None:
    """Within the context the new values hold, after it the old ones."""
    link = VirtualLink(LinkConditions(loss=loss))
    parameters = link.autopilot.parameters
    before = parameters["WPNAV_SPEED"]
    with parameters_set(link, {"WPNAV_SPEED": 1500.0, "WPNAV_ACCEL": 400.0}):
        assert (parameters["WPNAV_SPEED"], parameters["WPNAV_ACCEL"]) == (1500.0, 400.0)
    assert parameters["WPNAV_SPEED"] == before


def test_an_error_restores_the_values_too() -> None:
    """Every way out restores the vehicle."""
    link = VirtualLink()
    before = link.autopilot.parameters["WPNAV_SPEED"]
    with pytest.raises(KeyboardInterrupt), parameters_set(link, {"WPNAV_SPEED": 1500.0}):
        raise KeyboardInterrupt
    assert link.autopilot.parameters["WPNAV_SPEED"] == before


@pytest.mark.parametrize("lost", ["", "RTL_ALT"])
def test_an_interrupt_while_they_are_put_back_puts_them_back(lost: str) -> None:
    """Ctrl-C right after a flight, when all seems to be done; what the vehicle does not confirm is told."""
    link = VirtualLink()
    before = dict(link.autopilot.parameters)
    told: list[Mapping[str, str]] = []
    send, interrupts = link.send, [KeyboardInterrupt]

    def interrupted_send(message: Message) -> None:
        is_put_back = message.get_type() == "PARAM_SET" and message.param_value == before[message.param_id]
        if is_put_back and interrupts:
            raise interrupts.pop()
        if not is_put_back or message.param_id != lost:
            send(message)

    link.send = interrupted_send  # type: ignore[method-assign]
    with (
        pytest.raises(KeyboardInterrupt),
        parameters_set(link, {"WPNAV_SPEED": 1500.0, "RTL_ALT": 3000.0}, told.append),
    ):
        began_s = link.now_s()
    assert link.now_s() - began_s < 5.0
    assert link.autopilot.parameters["WPNAV_SPEED"] == before["WPNAV_SPEED"]
    assert (link.autopilot.parameters["RTL_ALT"] == before["RTL_ALT"]) == (not lost)
    assert told == [{lost: "the vehicle does not answer"} if lost else {}]


def test_an_unknown_parameter_cannot_be_set() -> None:
    """The error names it."""
    with (
        pytest.raises(VehicleError, match="no parameter WP_SPD"),
        parameters_set(VirtualLink(), {"WP_SPD": 12.0}),
    ):
        raise AssertionError


def test_a_value_that_is_not_confirmed_is_an_error() -> None:
    """The error has name and value."""
    link = VirtualLink(LinkConditions(loss=1.0))
    with pytest.raises(
        VehicleError, match="cannot set parameter WPNAV_SPEED to 5: the vehicle does not answer"
    ):
        write_parameters(link, {"WPNAV_SPEED": 5.0}, limit_s=2.0)


@pytest.mark.parametrize(
    ("loss", "unset"),
    [
        (0.0, {"NO_SUCH_NAME": "its firmware has no such parameter"}),
        (0.3, {"NO_SUCH_NAME": "its firmware has no such parameter"}),
        (1.0, dict.fromkeys(("WPNAV_SPEED", "NO_SUCH_NAME"), "the vehicle does not answer")),
    ],
)
def test_what_the_vehicle_does_not_confirm_is_told(loss: float, unset: dict[str, str]) -> None:
    """With the reason, as far as it can be known; the others are set."""
    link = VirtualLink(LinkConditions(loss=loss))
    assert set_parameters(link, {"WPNAV_SPEED": 600.0, "NO_SUCH_NAME": 1.0}, ["RTL_ALT"]) == unset
    assert (link.autopilot.parameters["WPNAV_SPEED"] == 600.0) == (loss < 1.0)


def test_a_value_that_the_vehicle_does_not_take_is_told() -> None:
    """With the one that it has: this parameter is an integer."""
    assert set_parameters(VirtualLink(), {"FENCE_ENABLE": 0.4}) == {"FENCE_ENABLE": "it stays 0"}


def test_limits_become_parameters_in_the_vehicles_own_units() -> None:
    """Metres per second become the centimetres per second of this firmware."""
    wanted = limits_as_parameters(VirtualLink(), {"wp_speed_m_s": 12.5, "wp_jerk_m_s3": 8.0})
    assert wanted == {"WPNAV_SPEED": 1250.0, "WPNAV_JERK": 8.0}


@pytest.mark.parametrize("seed", range(40))
def test_lost_requests_do_not_lengthen_the_round_trip(seed: int) -> None:
    """Seconds of lost requests before the first answer are not measured: uploads would wait for them."""
    link = VirtualLink(LinkConditions(loss=0.4), seed=seed, speedup=20.0)
    link.round_trip = RoundTrip()
    identify(link, DiscoveredVehicle(1, 1, 2, 3))
    assert link.round_trip.median_s < 0.1


def test_the_built_in_copter_is_a_version_in_development() -> None:
    """As the one that it flies as: a released one turns corners in another way."""
    identity = identify(VirtualLink(), DiscoveredVehicle(1, 1, 2, 3))
    assert (*identity.version_numbers, identity.maturity) == (4, 6, 0, 0)
