"""A mission and a track with everything that the file formats hold."""

import numpy as np
import pytest

from flight_replay.logs.track import Track, track_from_columns
from flight_replay.mission.items import Command, Frame, Home, Mission, MissionItem, change_speed, waypoint

HOME = Home(47.39774213, 8.54559412, 488.25)


MISSION = Mission(
    (
        waypoint(47.39784213, 8.54569412, 30.0),
        change_speed(4.25),
        waypoint(47.39794213, 8.54579412, 31.5, hold_s=2, spline=True),
        waypoint(47.39804213, 8.54589412, 32.0, spline=True),
        MissionItem(Command.WAYPOINT, Frame.ABSOLUTE, (0.0, 0.0, 0.0, 0.0), 47.398, 8.546, 520.0),
        MissionItem(Command.RETURN_TO_LAUNCH, Frame.MISSION, (0.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0),
    ),
    HOME,
)


def recorded_track() -> Track:
    """Four fixes in two boots, one of them without a height above the sea."""
    return track_from_columns(
        np.array([0.0, 0.4, 0.8, 1.2]),
        np.array([47.3977, 47.3978, 47.3979, 47.398]),
        np.array([8.5455, 8.5456, 8.5457, 8.5458]),
        np.array([0.0, 1.0, 2.0, -0.0]),
        amsl_m=np.array([488.0, 489.0, np.nan, 488.0]),
        boot=np.array([0, 0, 1, 1], np.int32),
    )


def assert_same(mission: Mission, other: Mission) -> None:
    """Every number survives to 1e-8 in its unit; a place is then 1 mm off at most."""
    assert [(item.command, item.frame) for item in other.items] == [
        (item.command, item.frame) for item in mission.items
    ]
    for was, item in zip(mission.items, other.items, strict=True):
        wanted = (*was.params, was.lat_deg, was.lon_deg, was.alt_m)
        got = (*item.params, item.lat_deg, item.lon_deg, item.alt_m)
        assert got == pytest.approx(wanted, abs=0.6e-8, nan_ok=True)
