"""Altitudes to fly at: constant, or as recorded where that is plausible and not too low."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.exceptions import MissionError
from flight_replay.logs.track import Armed, Track
from flight_replay.mission.items import Home
from flight_replay.planning.altitude import altitudes_m, home_of, plausible_altitudes_m
from tests.helpers.made_tracks import straight_track


def track_at(alt_m: list[float], home_amsl_m: float | list[float] = 400.0) -> Track:
    """One fix a second at altitudes above a home that is so high above the sea."""
    track = straight_track(fixes=len(alt_m), altitudes_m=alt_m)
    return replace(track, amsl_m=track.alt_m + np.asarray(home_amsl_m, float))


def test_home_is_the_ground_below_the_first_fix() -> None:
    """Its altitude above the sea is what the fix is higher above the sea than above home, if any tells."""
    track = track_at([12.0, 50.0], [400.0, 300.0])
    home = Home(float(track.lat_deg[0]), float(track.lon_deg[0]), 400.0)
    assert home_of(track) == home
    unknown_at_first = replace(track, amsl_m=np.append(np.nan, track.amsl_m[1:]))
    assert home_of(unknown_at_first) == replace(home, alt_amsl_m=300.0)
    assert home_of(replace(track, amsl_m=np.full(2, np.nan))) == replace(home, alt_amsl_m=None)
    assert home_of(track_at([412.0, 50.0], [0.0, 400.0])).alt_amsl_m == 400.0
    assert home_of(track_at([12.0, 50.0], 0.0)).alt_amsl_m == 0.0


def test_a_given_altitude_is_flown_whatever_was_recorded() -> None:
    """Even below the lowest recorded altitude that is flown."""
    assert altitudes_m(track_at([12.0, 50.0]), 3.0).tolist() == [3.0, 3.0]


def test_recorded_altitudes_are_flown_but_none_below_the_lowest() -> None:
    """Whatever lies below 5 m is flown at 5 m."""
    assert altitudes_m(track_at([-1.0, 4.9, 5.1, 70.0]), "recorded").tolist() == [5.0, 5.0, 5.1, 70.0]


def test_altitudes_from_before_home_was_set_are_replaced() -> None:
    """A home more than 20 m off the boot's median is implausible; the next plausible altitude is taken."""
    track = track_at([420.0, 10.0, 11.0, 12.0, 13.0, 14.0], [0.0, 420.1, 400.0, 400.0, 419.9, 400.0])
    assert plausible_altitudes_m(track).tolist() == [11.0, 11.0, 11.0, 12.0, 13.0, 14.0]


def test_at_the_end_the_last_plausible_altitude_is_taken() -> None:
    """Nothing plausible follows there."""
    track = track_at([10.0, 11.0, 12.0, 500.0, np.nan], [400.0, 400.0, 400.0, -90.0, 400.0])
    assert plausible_altitudes_m(track).tolist() == [10.0, 11.0, 12.0, 12.0, 12.0]


def test_a_home_20_m_off_is_plausible() -> None:
    """Just so far."""
    track = track_at([10.0, 11.0, 12.0], [400.0, 420.0, 400.0])
    assert plausible_altitudes_m(track).tolist() == [10.0, 11.0, 12.0]


def test_a_fix_without_a_height_above_the_sea_takes_the_next_ones() -> None:
    """The other fixes of the boot keep theirs."""
    assert plausible_altitudes_m(track_at([10.0, 11.0, 12.0], [400.0, np.nan, 400.0])).tolist() == [
        10,
        12,
        12,
    ]


def test_each_boot_has_its_own_home() -> None:
    """A home that is 100 m higher after a reboot is as plausible as the first one."""
    track = track_at([10.0, 11.0, 12.0, 13.0, 14.0], [400.0, 400.0, 500.0, 500.0, 400.0])
    track = replace(track, boot=np.array([0, 0, 1, 1, 1], np.int32))
    assert plausible_altitudes_m(track).tolist() == [10.0, 11.0, 12.0, 13.0, 13.0]


@pytest.mark.parametrize("raised_m", [8.0, 45.0, -12.0])
def test_a_home_that_is_moved_in_flight_is_no_climb(raised_m: float) -> None:
    """Nor a fall to the ground: the vehicle stays where it is."""
    moved_m = 400.0 + raised_m
    track = track_at([50.0, 51.0, 52.0 - raised_m, 53.0 - raised_m], [400.0, 400.0, moved_m, moved_m])
    flying = replace(track, armed=np.full(4, Armed.YES, np.int8))
    assert plausible_altitudes_m(flying).tolist() == [50.0, 51.0, 52.0, 53.0]


def test_each_flight_has_its_own_home() -> None:
    """Of an arming, on a roof: its altitudes are above that."""
    track = track_at([50.0, 51.0, 49.0, 20.0, 21.0], [400.0, 400.0, 400.0, 410.0, 410.0])
    flying = replace(track, armed=np.full(5, Armed.YES, np.int8))
    later = replace(flying, time_s=flying.time_s + np.array([0, 0, 0, 60, 60]))
    disarmed = replace(flying, armed=np.array([1, 1, 0, 1, 1], np.int8))
    assert (
        plausible_altitudes_m(later).tolist()
        == plausible_altitudes_m(disarmed).tolist()
        == [50, 51, 49, 20, 21]
    )


def test_home_is_not_moved_by_a_gps_altitude_that_is() -> None:
    """The barometer's altitude above home goes on, the GPS's above the sea steps."""
    track = track_at([50.0, 51.0, 52.0, 53.0], [400.0, 400.0, 408.0, 408.0])
    flying = replace(track, armed=np.full(4, Armed.YES, np.int8))
    assert plausible_altitudes_m(flying).tolist() == [50.0, 51.0, 52.0, 53.0]


def test_home_set_in_flight_for_the_first_time_is_none_moved() -> None:
    """Before, altitudes above home are those above the sea."""
    track = track_at([450.0, 51.0, 52.0, 53.0], [0.0, 400.0, 400.0, 400.0])
    flying = replace(track, armed=np.full(4, Armed.YES, np.int8))
    assert plausible_altitudes_m(flying).tolist() == [51.0, 51.0, 52.0, 53.0]


@pytest.mark.parametrize("boots", [[0, 0, 0], [0, 1, 1]])
def test_unknown_altitudes_cannot_be_flown(boots: list[int]) -> None:
    """Without any altitude above home, none is plausible: a vehicle must not come down for that."""
    track = replace(track_at([30.0, 30.0, 30.0]), boot=np.array(boots, np.int32))
    unknown = replace(track, alt_m=np.full(3, np.nan))
    with pytest.raises(MissionError, match="the recording has no heights; choose one in metres, such as"):
        altitudes_m(unknown, "recorded")
    assert altitudes_m(unknown, 12.0).tolist() == [12.0] * 3


def test_altitudes_above_home_alone_are_plausible() -> None:
    """Where a boot tells nothing of the sea, as a track above the ground."""
    track = replace(track_at([30.0, 31.0, 32.0]), amsl_m=np.full(3, np.nan))
    assert plausible_altitudes_m(track).tolist() == [30.0, 31.0, 32.0]
