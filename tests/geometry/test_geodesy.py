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
