"""QGroundControl's .plan: the guide's format, and what is refused."""

import json
import math

import pytest

from flight_replay.exceptions import MissionError
from flight_replay.mission import formats
from tests.helpers.format_examples import HOME, MISSION


def _plan(*rows: object, home: object = (1, 2, 3)) -> str:
    return json.dumps({"mission": {"plannedHomePosition": home, "items": rows}})


SIMPLE = {"type": "SimpleItem", "command": 16, "frame": 3, "params": [0, 0, 0, None, 1, 2, 3]}


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("{", "is not a QGroundControl plan"),
        ("[]", "is not a QGroundControl plan"),
        ('{"mission": {}}', "is not a QGroundControl plan"),
        (_plan(home=[1, 2]), "is not a QGroundControl plan"),
        (_plan({"type": "ComplexItem", "complexItemType": "survey"}), "item 1 is a survey pattern"),
        (_plan(SIMPLE, {**SIMPLE, "params": [0, 1]}), "item 2 is not a SimpleItem of seven numbers"),
        ("[" * 100_000, "is not a QGroundControl plan"),
        (_plan(home=[1e300, 2, 3]), "plannedHomePosition has invalid coordinates"),
        (_plan(home=[10**400, 2, 3]), "is not a QGroundControl plan"),
        (_plan({**SIMPLE, "command": 70000}), "item 1 has command 70000"),
        (_plan({**SIMPLE, "command": math.inf}), "item 1 is not a SimpleItem"),
        (_plan({**SIMPLE, "frame": 300}), "item 1 has frame 300"),
        (_plan({**SIMPLE, "params": [0, 0, 0, 1e39, 1, 2, 3]}), r"item 1 has param4 1e\+39"),
        (_plan("text"), "item 1 is not a SimpleItem"),
        (_plan({**SIMPLE, "params": [0, 0, 0, 0, None, 2, 3]}), "item 1 has invalid coordinates"),
    ],
)
def test_broken_plans_are_told_with_their_item(content: str, said: str) -> None:
    """Each error names the file and the item, and what is wrong there."""
    with pytest.raises(MissionError, match=f"^m.plan.*{said}"):
        formats.qgc_plan.parse(content, "m.plan")


def test_a_command_without_a_place_may_leave_its_coordinates_out() -> None:
    """A null is 0 in MAVLink's integers, which know no number that is none."""
    row = {**SIMPLE, "command": 178, "params": [1, 5, -1, 0, None, None, None]}
    item = formats.qgc_plan.parse(_plan(row), "m.plan").items[0]
    assert (item.lat_deg, item.lon_deg) == (0.0, 0.0)


PLAN_SCHEMA = {
    "type": "object",
    "required": ["fileType", "version", "groundStation", "mission", "geoFence", "rallyPoints"],
    "properties": {
        "fileType": {"const": "Plan"},
        "version": {"const": 1},
        "groundStation": {"type": "string"},
        "mission": {
            "type": "object",
            "required": [
                "version",
                "firmwareType",
                "vehicleType",
                "cruiseSpeed",
                "hoverSpeed",
                "plannedHomePosition",
                "items",
            ],
            "properties": {
                "version": {"const": 2},
                "firmwareType": {"const": 3},
                "vehicleType": {"const": 2},
                "cruiseSpeed": {"type": "number", "exclusiveMinimum": 0},
                "hoverSpeed": {"type": "number", "exclusiveMinimum": 0},
                "globalPlanAltitudeMode": {"type": "integer"},
                "plannedHomePosition": {
                    "type": "array",
                    "items": {"type": "number"},
                    "minItems": 3,
                    "maxItems": 3,
                },
                "items": {"type": "array", "items": {"$ref": "#/$defs/simple"}},
            },
        },
        "geoFence": {
            "required": ["version", "circles", "polygons"],
            "properties": {"version": {"const": 2}},
        },
        "rallyPoints": {"required": ["version", "points"], "properties": {"version": {"const": 2}}},
    },
    "$defs": {
        "simple": {
            "type": "object",
            "required": ["type", "autoContinue", "command", "doJumpId", "frame", "params"],
            "properties": {
                "type": {"const": "SimpleItem"},
                "autoContinue": {"type": "boolean"},
                "command": {"type": "integer", "minimum": 0},
                "doJumpId": {"type": "integer", "minimum": 1},
                "frame": {"enum": [0, 2, 3, 10]},
                "params": {
                    "type": "array",
                    "items": {"type": ["number", "null"]},
                    "minItems": 7,
                    "maxItems": 7,
                },
                "AltitudeMode": {"enum": [1, 2, 3, 4]},
                "Altitude": {"type": "number"},
                "AMSLAltAboveTerrain": {"type": ["number", "null"]},
            },
            "if": {"properties": {"command": {"enum": [16, 82]}}},
            "then": {"required": ["AltitudeMode", "Altitude", "AMSLAltAboveTerrain"]},
        }
    },
}
"""The .plan format of QGroundControl's developer guide, as far as missions go."""


def test_plan_keeps_to_the_format_of_the_developer_guide() -> None:
    """The file agrees with a JSON schema of the guide's tables."""
    jsonschema = pytest.importorskip("jsonschema")
    plan = json.loads(formats.qgc_plan.text(MISSION))
    jsonschema.validate(plan, PLAN_SCHEMA)
    first = plan["mission"]["items"][0]
    assert (first["Altitude"], first["AltitudeMode"], first["doJumpId"]) == (30.0, 1, 1)
    assert plan["mission"]["items"][4]["AltitudeMode"] == 2
    assert "AltitudeMode" not in plan["mission"]["items"][1]
    assert plan["mission"]["hoverSpeed"] == 4.25
    assert plan["mission"]["plannedHomePosition"] == [HOME.lat_deg, HOME.lon_deg, HOME.alt_amsl_m]
