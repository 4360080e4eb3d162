"""The local frame measures ground distances as the ellipsoid has them."""

import math

import numpy as np
import pytest

from flight_replay.geometry.geodesy import LocalFrame, distance_m

PLACES = [(0.0, 0.0), (47.39, 8.54), (35.3, -120.6), (-64.2, 179.9999), (89.9995, 10.0), (-90.0, 0.0)]

# Lengths of one degree on WGS 84: meridian and parallel, by the closed forms of its radii of curvature.
A_M, E2 = 6378137.0, 0.00669437999014


def radii_m(lat_deg: float) -> tuple[float, float]:
    """Radii of curvature (meridian, prime vertical)."""
    w2 = 1 - E2 * math.sin(math.radians(lat_deg)) ** 2
    return A_M * (1 - E2) / w2**1.5, A_M / math.sqrt(w2)


@pytest.mark.parametrize(("lat_deg", "lon_deg"), PLACES)
def test_there_and_back_is_the_same_place(lat_deg: float, lon_deg: float) -> None:
    """Metres to degrees and back is exact to a micrometre, at the poles and the antimeridian too."""
    frame = LocalFrame(lat_deg, lon_deg)
    metres = np.random.default_rng(1).uniform(-5000, 5000, (500, 2))
    assert np.abs(frame.to_metres(*frame.to_degrees(metres)) - metres).max() < 1e-6


@pytest.mark.parametrize(("lat_deg", "lon_deg"), PLACES)
def test_frame_distances_are_ground_distances(lat_deg: float, lon_deg: float) -> None:
    """Distances in the frame agree with chords over the ellipsoid to 1 mm/km."""
    frame = LocalFrame(lat_deg, lon_deg)
    metres = np.random.default_rng(2).uniform(-5000, 5000, (500, 2))
    lat, lon = frame.to_degrees(metres)
    ground = distance_m(lat[:-1], lon[:-1], lat[1:], lon[1:])
    flat = np.linalg.norm(np.diff(metres, axis=0), axis=1)
    assert np.abs(flat / ground - 1).max() < 1e-6


@pytest.mark.parametrize("lat_deg", [0.0, 35.0, 60.0, -80.0])
def test_axes_point_north_and_east(lat_deg: float) -> None:
    """A small step in latitude is metres north, one in longitude metres east, by the radii of curvature."""
    meridian_m, vertical_m = radii_m(lat_deg)
    step_deg = 1e-4
    north, east = LocalFrame(lat_deg, 179.99995).to_metres(
        [lat_deg + step_deg, lat_deg], [179.99995, -180 + step_deg / 2]
    )
    assert north == pytest.approx([math.radians(step_deg) * meridian_m, 0], abs=1e-4)
    across_m = math.radians(step_deg) * vertical_m * math.cos(math.radians(lat_deg))
    assert east == pytest.approx([0, across_m], abs=1e-4)


def test_any_shape_of_positions_is_taken() -> None:
    """A single position gives one row, a grid a grid of rows, in both directions and for distances."""
    frame = LocalFrame(47.39, 8.54)
    assert frame.to_metres(47.39, 8.54).tolist() == [0.0, 0.0]
    assert frame.to_metres(47.3901, 8.5401).shape == (2,)
    assert float(frame.to_degrees([0.0, 0.0])[0]) == pytest.approx(47.39, abs=1e-12)
    grid = np.random.default_rng(3).uniform(-900, 900, (3, 4, 2))
    lat, lon = frame.to_degrees(grid)
    assert lat.shape == lon.shape == (3, 4)
    assert frame.to_metres(lat, lon) == pytest.approx(grid, abs=1e-6)
    assert distance_m(lat, lon, 47.39, 8.54) == pytest.approx(np.hypot(*np.moveaxis(grid, -1, 0)), rel=1e-6)
    assert float(distance_m(47.39, 8.54, 47.3901, 8.54)) == pytest.approx(11.12, abs=0.01)


@pytest.mark.parametrize("lon_deg", [45.0, 89.0])
def test_far_positions_are_roughly_as_far(lon_deg: float) -> None:
    """Up to a quarter around the earth, distances from the origin are within 1 % along the equator."""
    north_m, east_m = LocalFrame(0.0, 0.0).to_metres(0.0, lon_deg)
    assert east_m == pytest.approx(math.radians(lon_deg) * A_M, rel=0.01)
    assert north_m == pytest.approx(0.0, abs=1.0)


def test_beyond_a_quarter_of_the_earth_metres_are_numbers() -> None:
    """The other side of the earth cannot be drawn in the frame, and gives no error either."""
    assert np.isfinite(LocalFrame(10.0, 20.0).to_metres([-10.0, 0.0, 80.0], [-160.0, 110.0, 200.0])).all()
    assert np.isfinite(LocalFrame(0.0, 0.0).to_degrees([0.0, 1.2e7])).all()
