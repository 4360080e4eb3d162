"""The parameter table."""

from __future__ import annotations

import pytest

from flight_replay.mavlink import dialect
from flight_replay.simulator.autopilot.faults import COPTER_4_7, Faults
from flight_replay.simulator.autopilot.parameter_table import Parameters
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.sim_station import Station, sim


def test_defaults_are_arducopters() -> None:
    """The speeds, heights and failsafes are those of ArduCopter 4.6."""
    parameters = Parameters()
    assert parameters["WPNAV_SPEED"] == 1000
    assert parameters["RTL_ALT"] == 1500
    assert parameters["FS_GCS_ENABLE"] == 0
    assert parameters["DISARM_DELAY"] == 10


def test_every_parameter_has_a_legal_name_and_its_own_index() -> None:
    """Names fit MAVLink's 16 characters; the list can be walked by index."""
    parameters = Parameters()
    assert all(0 < len(name) <= 16 for name in parameters)
    assert [parameters.at(index).name for index in range(len(parameters))] == list(parameters)  # type: ignore[union-attr]
    assert parameters.at(len(parameters)) is None
    assert parameters.at(-1) is None


@pytest.mark.parametrize(
    ("name", "given", "kept"),
    [
        ("FENCE_ACTION", 2.5, 2.0),
        ("FENCE_ACTION", 2.9999, 3.0),
        ("FENCE_ACTION", -2.5, -2.0),
        ("FENCE_ACTION", 1000.0, 127.0),
        ("RTL_SPEED", 1e9, 32767.0),
        ("RTL_ALT", -5e9, -2147483648.0),
        ("WPNAV_SPEED", 0.1, 0.10000000149011612),
    ],
)
def test_values_are_kept_as_their_type_holds_them(name: str, given: float, kept: float) -> None:
    """Integers are cut and limited, real ones are 32 bit floats."""
    parameters = Parameters()
    assert parameters.assign(name, given).value == kept
    assert parameters[name] == kept


def test_an_unknown_parameter_is_not_invented() -> None:
    """A name that ArduCopter does not have is an error, not a new parameter."""
    with pytest.raises(KeyError):
        Parameters({"NO_SUCH": 1})


def test_the_full_list_comes_with_count_and_index() -> None:
    """PARAM_REQUEST_LIST brings every parameter once, with type, count and index, after a banner."""
    autopilot, station = sim()
    station.send(dialect.MAVLink_param_request_list_message(1, 1))
    station.run(5)
    values = station.of("PARAM_VALUE")
    assert [value.param_index for value in values] == list(range(len(autopilot.parameters)))
    assert {value.param_count for value in values} == {len(autopilot.parameters)}
    assert station.texts[0].startswith("ArduCopter V4.6.0")
    speed = next(value for value in values if value.param_id == "WPNAV_SPEED")
    assert (speed.param_value, speed.param_type) == (1000.0, dialect.MAV_PARAM_TYPE_REAL32)


def test_one_parameter_is_read_by_name_and_by_index() -> None:
    """The answer carries the index that was asked for, as ArduPilot's does."""
    autopilot, station = sim()
    station.send(dialect.MAVLink_param_request_read_message(1, 1, b"RTL_ALT", -1))
    by_name = station.last("PARAM_VALUE")
    assert (by_name.param_id, by_name.param_value, by_name.param_index) == ("RTL_ALT", 1500, 65535)
    index = list(autopilot.parameters).index("RTL_ALT")
    station.send(dialect.MAVLink_param_request_read_message(1, 1, b"", index))
    assert station.last("PARAM_VALUE").param_index == index
    assert station.last("PARAM_VALUE").param_id == "RTL_ALT"


def test_setting_is_heard_by_every_station() -> None:
    """A PARAM_SET is answered on all links with what is kept; unknown names and NaN are ignored."""
    autopilot, station = sim()
    other = Station(station.link, 254)
    station.send(dialect.MAVLink_param_set_message(1, 1, b"RTL_ALT", 2000.4, 6))
    assert station.last("PARAM_VALUE").param_value == other.last("PARAM_VALUE").param_value == 2000
    station.clear()
    station.send(dialect.MAVLink_param_set_message(1, 1, b"NO_SUCH", 1, 9))
    station.send(dialect.MAVLink_param_set_message(1, 1, b"RTL_ALT", float("nan"), 9))
    station.send(dialect.MAVLink_param_request_read_message(1, 1, b"NO_SUCH", -1))
    assert station.received == []
    assert autopilot.parameters["RTL_ALT"] == 2000


def test_copter_4_7_has_other_names_in_other_units() -> None:
    """Speeds are WP_SPD in m/s; the flight goes by them, and the old names are unknown to stations."""
    autopilot, station = sim(Faults(firmware=COPTER_4_7))
    station.send(dialect.MAVLink_param_request_read_message(1, 1, b"WPNAV_SPEED", -1))
    assert station.of("PARAM_VALUE") == []
    station.send(dialect.MAVLink_param_set_message(1, 1, b"WP_SPD", 7.5, 9))
    assert station.last("PARAM_VALUE").param_value == 7.5
    assert autopilot.parameters["WPNAV_SPEED"] == 750
    assert Limits.from_parameters(autopilot.parameters).wp_speed_m_s == 7.5
    assert station.command(520, 1) == 0
    assert station.last("AUTOPILOT_VERSION").flight_sw_version >> 16 == 0x0407
