"""comparison.py: two recordings of one motion, of which the second may cover a part."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.exceptions import LogError
from flight_replay.flight_modes import CopterMode
from flight_replay.geometry.arrays import Floats
from flight_replay.logs.recording import Recording
from flight_replay.logs.track import Track, track_from_columns
from flight_replay.output.comparison import compare_tracks, part_in


def loops(
    count: int,
    *,
    late_s: float = 0.0,
    beside_m: float | Floats = 0.0,
    hover_s: int = 10,
    apart_m: float = 30.0,
) -> Track:
    """So many circles of 40 m radius at 4 m/s with a hover before them, each farther east by 30 m.

    ``beside_m`` may be of every half second of the circles.
    """
    time_s = np.arange(0.0, count * 60.0, 0.5)
    turn = time_s / 60.0 * 2 * np.pi
    north = np.r_[np.zeros(hover_s * 2), (40.0 + beside_m) * np.sin(turn)]
    east = np.r_[np.zeros(hover_s * 2), apart_m * time_s / 60.0 + 40.0 - (40.0 + beside_m) * np.cos(turn)]
    lat, lon = 47.0 + north / 111_200.0, 8.0 + east / (111_200.0 * np.cos(np.radians(47.0)))
    times = np.arange(len(lat), dtype=np.float64) * 0.5 + late_s
    return track_from_columns(
        times.astype(np.float64), lat.astype(np.float64), lon.astype(np.float64), np.full(len(lat), 20.0)
    )


def test_equal_motions_have_no_error() -> None:
    """However late, and however long each hovered before."""
    errors = compare_tracks(loops(2), loops(2, late_s=77.0, hover_s=25)).errors
    assert errors.path_m.recorded_to_path.error.max() < 0.05
    assert errors.position_m.error.max() < 0.05


def test_climbs_at_the_ends_are_left_out() -> None:
    """As long as the vehicle has not moved a metre over the ground: either may climb there as it likes."""
    first, second = loops(2), loops(2, hover_s=25)
    climbs = replace(first, alt_m=np.where(np.arange(len(first)) < 20, np.arange(len(first)), 20.0))
    result = compare_tracks(climbs, second)
    assert result.errors.height_m.error.max() < 0.05
    assert result.fixes < len(first) - 20


def test_a_replay_of_a_part_is_measured_over_that() -> None:
    """A later circle that comes near the first one's end does not count."""
    result = compare_tracks(loops(3), loops(3, beside_m=0.5).select(slice(0, 120)))
    assert 80 < result.fixes < 120
    assert result.errors.path_m.recorded_to_path.error.mean() == pytest.approx(0.5, abs=0.1)
    assert result.errors.path_m.path_to_recorded.error.max() < 0.7


def test_a_replay_that_goes_on_is_measured_over_all_of_a_shorter_one() -> None:
    """As one of the whole flight against one of its first minute."""
    shorter = loops(3).select(slice(0, 120))
    result = compare_tracks(shorter, loops(3, beside_m=0.5))
    assert 90 < result.fixes < 120
    assert result.errors.path_m.recorded_to_path.error.mean() == pytest.approx(0.5, abs=0.1)
    assert result.errors.path_m.path_to_recorded.error.max() < 0.7


def test_a_copy_beside_is_beside_at_every_time() -> None:
    """Where it passes the first fix is not when: the motion there may be towards it."""
    first = loops(2)
    beside = replace(first, lat_deg=first.lat_deg + 0.5 / 111_200.0, time_s=first.time_s + 5.0)
    error_m = compare_tracks(first, beside).errors.position_m.error
    assert error_m.max() == pytest.approx(0.5, abs=0.03)
    assert error_m.mean() == pytest.approx(0.5, abs=0.02)


def test_a_replay_that_creeps_off_is_not_early_for_all_that_follows() -> None:
    """Fitted missions do where a recording hovers: 2.4 m in 5 s, and wait there for the recording."""
    first = loops(2)
    early, creep_m = slice(0, 24), np.clip(0.5 * (first.time_s[:24] - 1.0), 0.0, 2.4)
    lat_deg = first.lat_deg.copy()
    lat_deg[early] = np.maximum(lat_deg[early], 47.0 + creep_m / 111_200.0)
    creeping = replace(first, lat_deg=lat_deg, time_s=first.time_s + 5.0)
    assert compare_tracks(first, creeping).errors.position_m.error.mean() < 0.1


WIDER_M = np.where(np.arange(360) < 240, 0.3, 0.8)
"""Beside three circles by so much, the last one by more."""


@pytest.mark.parametrize(
    ("from_s", "to_s", "beside_m"),
    [(150.0, None, 0.8), (150.0, 170.0, 0.8), (None, 40.0, 0.3), (40.0, 60.0, 0.3)],
)
def test_a_part_of_a_replay_is_what_it_is_of_the_whole(
    from_s: float | None, to_s: float | None, beside_m: float
) -> None:
    """Though most of the replay has no counterpart there; both ways of the path error are of the part."""
    first, second = loops(3), loops(3, beside_m=WIDER_M, late_s=33.0)
    result = compare_tracks(first, second, from_s, to_s)
    errors = result.errors
    within_s = (to_s or 185.0) - max(from_s or 0.0, 10.0)
    assert result.fixes == pytest.approx(2 * within_s, abs=10)
    path = errors.path_m
    for each in (path.recorded_to_path, path.path_to_recorded, errors.position_m):
        assert each.error.mean() == pytest.approx(beside_m, abs=0.05)
        assert np.ptp(each.time_s) == pytest.approx(within_s, abs=4.0)
    assert len(path.place_m) == len(path.path_to_recorded) > 3 * within_s


def test_a_replay_of_one_of_many_laps_is_looked_for_where_it_was_flown() -> None:
    """Laps over the same places are told apart by the times given."""
    laps, lap = loops(3, apart_m=0.0), loops(1, apart_m=0.0, beside_m=0.4)
    result = compare_tracks(laps, lap, from_s=130.0)
    assert result.fixes == pytest.approx(120, abs=10)
    assert result.errors.path_m.recorded_to_path.error.mean() == pytest.approx(0.4, abs=0.05)
    assert result.errors.position_m.error.mean() == pytest.approx(0.4, abs=0.05)


def test_times_that_were_not_flown_again_are_refused() -> None:
    """One line says which were."""
    with pytest.raises(LogError, match=r"follows the first from 10\.\d to 6\d\.\d s; choose --from and --to"):
        compare_tracks(loops(3), loops(1), from_s=120.0)
    with pytest.raises(LogError, match="no fix lies between"):
        compare_tracks(loops(3), loops(1), from_s=1200.0)


def test_what_does_not_move_or_follow_is_refused() -> None:
    """One line says so."""
    here, away = loops(1), loops(1)
    with pytest.raises(LogError, match="does not move"):
        compare_tracks(here, here.select(slice(0, 10)))
    with pytest.raises(LogError, match="does not follow the first"):
        compare_tracks(here, replace(away, lat_deg=away.lat_deg + 0.1))


def test_a_replay_is_the_part_in_auto() -> None:
    """Of the modes asked for, the first that there is; else what was flown."""
    track = loops(1)
    modes = np.full(len(track), CopterMode.GUIDED, np.int16)
    modes[20:60] = CopterMode.AUTO
    recording = Recording(path="made", bytes=0, track=track, modes=modes)
    part, words = part_in(recording, [CopterMode.AUTO, CopterMode.GUIDED])
    assert (len(part), words) == (40, "its AUTO part")
    assert part_in(recording, [CopterMode.LOITER])[1] == "what was flown"


def test_a_take_off_in_guided_is_no_replay() -> None:
    """A mode in which a vehicle only hovered is passed over."""
    track = loops(1)
    modes = np.full(len(track), CopterMode.LOITER, np.int16)
    modes[track.time_s < 9.0] = CopterMode.GUIDED
    assert (modes == CopterMode.GUIDED).any()
    recording = Recording(path="made", bytes=0, track=track, modes=modes)
    part, words = part_in(recording, [CopterMode.AUTO, CopterMode.GUIDED])
    assert (part.time_s[-1], words) == (track.time_s[-1], "what was flown")
