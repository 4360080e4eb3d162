"""What ArduCopter stores of a mission item."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flight_replay.mavlink import dialect
from flight_replay.simulator.mission.stored_items import (
    ItemRejected,
    StoredItem,
    item_float,
    item_int,
    to_stored_item,
)
from flight_replay.simulator.mission.stored_params import float32

INVALID = dialect.MAV_MISSION_INVALID_PARAM1
LAT, LON = 473977420, 85455940


def as_int(**fields: Any) -> Any:
    """A MISSION_ITEM_INT; fields that are not given make it a sound waypoint."""
    sent: dict[str, Any] = {"frame": 3, "command": 16, "params": (0, 0, 0, 0), "x": LAT, "y": LON, "z": 20.0}
    sent |= fields
    return dialect.MAVLink_mission_item_int_message(
        1, 1, 1, sent["frame"], sent["command"], 0, 1, *sent["params"], sent["x"], sent["y"], sent["z"]
    )


def as_float(lat: float, lon: float) -> Any:
    """A MISSION_ITEM waypoint, as its floats arrive."""
    return dialect.MAVLink_mission_item_message(
        1, 1, 1, 3, 16, 0, 1, 0, 0, 0, 0, float32(lat), float32(lon), 20.0
    )


def refusal(message: Any) -> int:
    with pytest.raises(ItemRejected) as caught:
        to_stored_item(message)
    return caught.value.result


@given(
    st.integers(-90 * 10**7, 90 * 10**7),
    st.integers(-180 * 10**7, 180 * 10**7),
    st.floats(-1000, 30000, width=32),
)
def test_locations_of_item_int_are_kept_exactly(x: int, y: int, z: float) -> None:
    """Degrees times 1e7 come back bit for bit, altitudes to the centimetre."""
    back = item_int(to_stored_item(as_int(x=x, y=y, z=z)), 1, current=False, system=255, component=0)
    assert (back.x, back.y) == (x, y)
    assert abs(back.z - z) <= 0.01 + abs(z) * 2**-23


@given(st.floats(-90, 90), st.floats(-180, 180))
def test_locations_of_float_items_lose_what_32_bit_floats_lose(lat: float, lon: float) -> None:
    """A MISSION_ITEM is off by at most half a step of its float, plus the step of the product."""
    item = to_stored_item(as_float(lat, lon))
    assert abs(item.lat_e7 / 1e7 - lat) <= abs(lat) * 2**-23 + 1e-7
    assert abs(item.lon_e7 / 1e7 - lon) <= abs(lon) * 2**-23 + 1e-7


def test_far_east_a_float_item_can_be_a_metre_off() -> None:
    """Beyond 128 degrees a float has steps of 1.5e-5 degrees, and of 128 once multiplied by 1e7."""
    meant = range(1491652000, 1491653000, 10)
    off = [abs(to_stored_item(as_float(-35.363261, lon / 1e7)).lon_e7 - lon) for lon in meant]
    assert 70 < max(off) <= 76 + 64


@pytest.mark.parametrize(
    ("command", "params", "kept"),
    [
        (16, (2.9, 5, 7, 90), (2, 0, 0, 0)),
        (16, (-1, 0, 0, math.nan), (0, 0, 0, 0)),
        (17, (0, 0, -12.5, 0), (0, 0, -12, 0)),
        (18, (2, 0, 15, 1), (2, 0, 15, 1)),
        (18, (0.5, 0, -1234, 0), (0.5, 0, -1230, 0)),
        (18, (300, 0, 9999, 0), (255, 0, 2550, 0)),
        (19, (30.7, 0, -1, 0), (30, 0, -1, 0)),
        (20, (1, 2, 3, 4), (0, 0, 0, 0)),
        (21, (0, 0, 0, -1), (0, 0, 0, -1)),
        (22, (15, 0, 0, math.nan), (15, 0, 0, 0)),
        (82, (3, 9, 9, 9), (3, 0, 0, 0)),
        (93, (2.5, -1, -1, -1), (2.5, -1, -1, -1)),
        (94, (2.345, 0, 0, 0), (2.34, 0, 0, 0)),
        (115, (90, 20, -1, 1), (90, 20, -1, 1)),
        (177, (3, -1, 0, 0), (3, -1, 0, 0)),
        (178, (1, 4.5, -1, 7), (1, 4.5, -1, 0)),
    ],
)
def test_parameters_are_kept_as_far_as_there_is_room(command: int, params: object, kept: object) -> None:
    """Each command keeps what ArduCopter's 15 bytes hold of its parameters."""
    assert to_stored_item(as_int(command=command, params=params)).params == kept


def test_commands_without_a_place_keep_none() -> None:
    """Whatever a DO item carries as latitude, longitude or frame is gone."""
    item = to_stored_item(as_int(command=178, frame=3))
    assert (item.frame, item.lat_e7, item.lon_e7, item.alt_cm) == (0, 0, 0, 0)


@pytest.mark.parametrize(("sent", "kept"), [(0, 0), (5, 0), (2, 0), (3, 3), (6, 3), (10, 10), (11, 10)])
def test_frames_are_kept_in_their_plain_form(sent: int, kept: int) -> None:
    """The _INT frames are the same frames."""
    assert to_stored_item(as_int(frame=sent)).frame == kept


@pytest.mark.parametrize(
    ("message", "result"),
    [
        (as_int(command=0), dialect.MAV_MISSION_INVALID),
        (as_int(command=2999), dialect.MAV_MISSION_UNSUPPORTED),
        (as_int(frame=1), dialect.MAV_MISSION_UNSUPPORTED_FRAME),
        (as_int(params=(math.nan, 0, 0, 0)), INVALID),
        (as_int(params=(0, math.inf, 0, 0)), INVALID + 1),
        (as_int(command=82, params=(0, 0, 0, math.nan)), INVALID + 3),
        (as_int(x=900000001), INVALID + 4),
        (as_int(y=-1800000001), INVALID + 5),
        (as_int(z=math.nan), INVALID + 6),
        (as_int(z=90000.0), INVALID + 6),
        (as_float(90.1, 8), INVALID + 4),
        (as_float(47, math.nan), INVALID + 5),
    ],
    ids=lambda value: value.to_json()[:90] if hasattr(value, "to_json") else str(value),
)
def test_bad_items_are_refused_with_arducopters_code(message: object, result: int) -> None:
    """Each kind of bad item has its MAV_MISSION_RESULT."""
    assert refusal(message) == result


def test_an_item_reads_back_as_float_or_int() -> None:
    """Both forms name command, frame, parameters and altitude alike; the float form rounds the location."""
    item = StoredItem(16, 3, (1.0, 0.0, 0.0, 0.0), 473977421, -1791234567, 2050)
    exact = item_int(item, 7, current=True, system=255, component=190)
    rounded = item_float(item, 7, current=False, system=255, component=190)
    for back in (exact, rounded):
        assert (back.seq, back.command, back.frame, back.param1, back.z) == (7, 16, 3, 1.0, 20.5)
        assert (back.target_system, back.target_component, back.autocontinue) == (255, 190, 1)
    assert (exact.x, exact.y, exact.current) == (473977421, -1791234567, 1)
    assert (rounded.x, rounded.current) == (float32(rounded.x), 0)
    assert abs(rounded.y + 179.1234567) < 2e-5
