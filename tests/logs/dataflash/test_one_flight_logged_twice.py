"""A real ArduCopter's flight is the same by its DataFlash log as by its telemetry log."""

from __future__ import annotations

import numpy as np
import pytest

from flight_replay.geometry.geodesy import distance_m
from flight_replay.logs.flights import find_flights, select
from flight_replay.logs.read_log import read_log
from flight_replay.logs.recording import Recording
from tests.helpers.paths import DATAFLASH


@pytest.fixture(scope="module")
def logged() -> tuple[Recording, Recording]:
    """The flight as it was logged on board, and over the link."""
    return read_log(DATAFLASH / "square.bin.gz"), read_log(DATAFLASH / "square.tlog.gz")


def test_positions_heights_and_headings_are_the_same_at_equal_times(
    logged: tuple[Recording, Recording],
) -> None:
    """Between two records on board, those sent meanwhile lie on the line, to 2 cm, 5 cm and a degree."""
    on_board, sent = (each.track for each in logged)
    sent = sent.select((sent.time_s >= on_board.time_s[0]) & (sent.time_s <= on_board.time_s[-1]))
    assert len(sent) > 400
    columns = on_board.lat_deg, on_board.lon_deg, on_board.alt_m, on_board.amsl_m
    lat, lon, alt_m, amsl_m = (np.interp(sent.time_s, on_board.time_s, column) for column in columns)
    assert distance_m(lat, lon, sent.lat_deg, sent.lon_deg).max() < 0.02
    assert np.abs(alt_m - sent.alt_m).max() < 0.05
    assert np.abs(amsl_m - sent.amsl_m).max() < 0.05
    unwrapped_deg = np.unwrap(on_board.heading_deg, period=360)
    turned_deg = np.interp(sent.time_s, on_board.time_s, unwrapped_deg) - sent.heading_deg
    assert np.abs((turned_deg + 180) % 360 - 180).max() < 1.0


def test_velocities_are_the_same_at_equal_times(logged: tuple[Recording, Recording]) -> None:
    """Those of the estimator on board are those sent, which are rounded to a centimetre a second."""
    on_board, sent = (each.track for each in logged)
    sent = sent.select((sent.time_s >= on_board.time_s[0]) & (sent.time_s <= on_board.time_s[-1]))
    for name in ("north_m_s", "east_m_s", "up_m_s"):
        ours = np.interp(sent.time_s, on_board.time_s, getattr(on_board, name))
        assert np.abs(ours - getattr(sent, name)).max() < 0.05


def test_the_flight_has_the_same_times(logged: tuple[Recording, Recording]) -> None:
    """Over the link the autopilot says when it arms and disarms: to a position's time, both logs agree."""
    (ours,), (theirs,) = (find_flights(each.track) for each in logged)
    assert ours.end_s - ours.start_s == pytest.approx(theirs.end_s - theirs.start_s, abs=0.3)
    for ends in ((ours.first, theirs.first), (ours.last, theirs.last)):
        on_board_s, sent_s = (float(each.track.time_s[at]) for each, at in zip(logged, ends, strict=True))
        assert sent_s == pytest.approx(on_board_s, abs=0.3)
    lengths_m = [select(each.track, 1).length_m for each in logged]
    assert lengths_m[0] == pytest.approx(lengths_m[1], abs=0.5)


def test_the_log_tells_of_its_vehicle(logged: tuple[Recording, Recording]) -> None:
    """Firmware, frame, ids, and what could not be read."""
    on_board, sent = logged
    assert (on_board.format, on_board.firmware) == ("dataflash", "ArduCopter V4.6.0-dev")
    assert (on_board.vehicle_type, on_board.is_multicopter) == (sent.vehicle_type, True)
    assert on_board.vehicle is not None
    assert sent.vehicle is not None
    assert on_board.vehicle.id == sent.vehicle.id
    assert on_board.bytes == 4_665_344
    assert on_board.notes == ("15 bytes could not be read",)
