"""The classic ways to thin a track, for comparison with the fit: each picks at most N of the fixes.

Every reducer takes ground metres (n, 2) and the most fixes to keep, and returns indices, ends included.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.geometry.polyline import nearest_on_segments
from flight_replay.planning.fit.first_drafts.line_simplification import douglas_peucker

Indices = NDArray[np.intp]
Reducer = Callable[[Floats, int], Indices]
_BISECTIONS = 40
_REACH = 4
# GPSBabel wants degrees; where they are does not matter.
_SOMEWHERE = LocalFrame(10.0, 20.0)


def spaced(points_m: Floats, most: int, spacing_m: float = 3.0) -> Indices:
    """DroneKit's rule: every fix more than 3 m from the last kept one, until there are enough."""
    kept = [0]
    for i in range(1, len(points_m)):
        if len(kept) < most and np.linalg.norm(points_m[i] - points_m[kept[-1]]) > spacing_m:
            kept.append(i)
    return np.array(kept, np.intp)


def visvalingam(points_m: Floats, most: int) -> Indices:
    """Visvalingam and Whyatt, by the package ``simplification``: smallest triangles go first."""
    from simplification.cutil import simplify_coords_vw_idx

    low, high = 0.0, 1e6
    for _ in range(_BISECTIONS):
        middle = (low * high) ** 0.5 if low > 0 else high / 1e12
        if len(simplify_coords_vw_idx(points_m, middle)) > most:
            low = middle
        else:
            high = middle
    return np.array(simplify_coords_vw_idx(points_m, high), np.intp)


def gpsbabel(points_m: Floats, most: int, method: str) -> Indices:
    """GPSBabel's simplify filter, by ``crosstrack`` or ``length``; its program has to be installed."""
    lat, lon = _SOMEWHERE.to_degrees(points_m)
    points = "".join(f'<trkpt lat="{a:.9f}" lon="{b:.9f}"/>' for a, b in zip(lat, lon, strict=True))
    gpx = f'<gpx version="1.1"><trk><trkseg>{points}</trkseg></trk></gpx>'
    command = [
        "gpsbabel",
        "-t",
        "-i",
        "gpx",
        "-f",
        "-",
        "-x",
        f"simplify,{method},count={most}",
        "-o",
        "gpx",
        "-F",
        "-",
    ]
    done = subprocess.run(command, input=gpx, capture_output=True, text=True, check=True, timeout=300)
    left = re.findall(r'<trkpt lat="([-\d.]+)" lon="([-\d.]+)"', done.stdout)
    kept = _SOMEWHERE.to_metres([float(a) for a, _ in left], [float(b) for _, b in left])
    return _in_order_indices(points_m, kept)


def _in_order_indices(points_m: Floats, kept_m: Floats) -> Indices:
    """Indices of kept points that came back rounded: the first near enough, ever forwards."""
    found, begin = [], 0
    for place in kept_m:
        near = np.linalg.norm(points_m[begin:] - place, axis=1) < 0.01
        begin += int(np.argmax(near))
        found.append(begin)
    return np.array(found, np.intp)


def min_max(points_m: Floats, most: int) -> Indices:
    """The corners among the fixes whose lines leave the farthest fix nearest (Imai and Iri, 1988).

    Legs over more than ``_REACH`` times the usual number of fixes are not looked at.
    """
    reach = min(len(points_m) - 1, max(2, _REACH * len(points_m) // most))
    error = _leg_errors(points_m, reach)
    low, high = 0.0, float(error[np.isfinite(error)].max())
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        if len(_fewest_corners(error <= middle)) > most:
            low = middle
        else:
            high = middle
    return _fewest_corners(error <= high)


def _leg_errors(points_m: Floats, reach: int) -> Floats:
    """Largest distance of the fixes between i and i + 1 + k from their line, shape (n, reach)."""
    n = len(points_m)
    errors = np.full((n, reach), np.inf)
    for i in range(n - 1):
        ends = points_m[i + 1 : i + 1 + reach] - points_m[i]
        _, apart = nearest_on_segments(ends, np.zeros_like(ends)[:, None], ends[:, None])
        errors[i, : len(ends)] = np.tril(apart).max(axis=1)
    return errors


def _fewest_corners(allowed: NDArray[np.bool_]) -> Indices:
    """The shortest chain of allowed legs from the first fix to the last."""
    n, reach = allowed.shape
    legs = np.full(n, n, np.intp)
    come_from = np.zeros(n, np.intp)
    legs[0] = 0
    for i in range(n - 1):
        ends = i + 1 + np.flatnonzero(allowed[i, : min(reach, n - 1 - i)])
        better = ends[legs[ends] > legs[i] + 1]
        legs[better], come_from[better] = legs[i] + 1, i
    chain = [n - 1]
    while chain[-1] > 0:
        chain.append(int(come_from[chain[-1]]))
    return np.array(chain[::-1], np.intp)


def reducers() -> dict[str, Reducer]:
    """The reducers that can run here, by name."""
    found: dict[str, Reducer] = {
        "3 m rule": spaced,
        "Douglas-Peucker": douglas_peucker,
        "Visvalingam": visvalingam,
        "min-max optimum": min_max,
    }
    if shutil.which("gpsbabel"):
        name = f"GPSBabel {_gpsbabel_version()}"
        found[f"{name} crosstrack"] = lambda points_m, most: gpsbabel(points_m, most, "crosstrack")
        found[f"{name} length"] = lambda points_m, most: gpsbabel(points_m, most, "length")
    return found


def _gpsbabel_version() -> str:
    """Its filters keep other fixes from one version to the next."""
    done = subprocess.run(["gpsbabel", "-V"], capture_output=True, text=True, check=True, timeout=60)
    return done.stdout.split()[-1]
