"""replay_status.py: the status of a replay after its events."""

import math

import pytest

from flight_replay.events import (
    Climbing,
    DistanceToWaypoint,
    Event,
    Finished,
    LinkLost,
    LinkRestored,
    Notice,
    Phase,
    PhaseStarted,
    Progress,
    ReturnCommanded,
    StatusText,
    VehicleState,
    Waiting,
)
from flight_replay.output.replay_status import STATUS_TEXTS_SHOWN, ReplayStatus, battery_text


def status_after(*events: Event) -> ReplayStatus:
    """The status after some events."""
    status = ReplayStatus()
    for event in events:
        status.update(event)
    return status


def state(battery_v: float | None = None, battery_percent: float | None = None) -> VehicleState:
    """A vehicle at 5 m/s."""
    return VehicleState(1.0, 47.0, 8.0, 30.0, (3.0, 4.0, 9.0), None, "AUTO", True, battery_v, battery_percent)


def test_the_latest_of_each_event_is_kept() -> None:
    """Phases that were started, the current waypoint, RTL and the end."""
    status = status_after(
        PhaseStarted(Phase.TAKEOFF),
        Climbing(1.0, 28.5, 30.0),
        PhaseStarted(Phase.MISSION),
        DistanceToWaypoint(23, 3.0, 100),
        ReturnCommanded(confirmed=True),
        Finished("duration"),
    )
    assert (status.phase, status.started) == (Phase.MISSION, [Phase.TAKEOFF, Phase.MISSION])
    assert status.target_altitude_m == 30.0
    assert status.current_waypoint == DistanceToWaypoint(23, 3.0, 100)
    assert (status.rtl_confirmed, status.ended) == (True, "duration")


def test_a_new_phase_ends_wait_and_progress() -> None:
    """Both belong to the phase before; progress that is complete ends by itself."""
    before = status_after(Waiting(Phase.PREARM, "no fix"), Progress("Uploading", 1, 2))
    assert (before.waiting, before.progress) == ("no fix", Progress("Uploading", 1, 2))
    after = status_after(
        Waiting(Phase.PREARM, "no fix"), Progress("Uploading", 1, 2), PhaseStarted(Phase.ARM)
    )
    assert (after.waiting, after.progress) == ("", None)
    assert status_after(Progress("Uploading", 2, 2)).progress is None


def test_a_restored_link_ends_the_warning() -> None:
    """A lost link is a warning until the link is restored."""
    assert status_after(LinkLost(4.2)).warning == "link lost"
    assert status_after(LinkLost(4.2), LinkRestored(5.0)).warning == ""
    assert status_after(Notice("the route is long", warning=True), Notice("x")).warning == "the route is long"


def test_the_last_texts_of_the_autopilot_are_kept() -> None:
    """As many as are shown."""
    texts = [StatusText(6, str(n)) for n in range(STATUS_TEXTS_SHOWN + 2)]
    assert status_after(*texts).status_texts == tuple(texts[2:])


def test_speed_is_the_horizontal_one() -> None:
    """Climbing does not count; before the first position the speed is NaN."""
    assert status_after(state()).speed_m_s == pytest.approx(5)
    assert math.isnan(ReplayStatus().speed_m_s)


@pytest.mark.parametrize(
    ("volts", "percent", "text"),
    [
        (12.61, 84.0, "12.6 V 84 %"),
        (10.5, 0.0, "10.5 V 0 %"),
        (12.61, None, "12.6 V"),
        (None, 84.0, "84 %"),
        (math.nan, None, ""),
    ],
)
def test_battery_values_that_are_not_known_are_left_out(
    volts: float | None, percent: float | None, text: str
) -> None:
    """None and NaN are not shown."""
    assert battery_text(state(volts, percent)) == text
