"""map_tiles.py: tiles in the local frame, and whether their server answers."""

import math
import socket

import pytest

from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.output.charts import map_tiles


@pytest.mark.parametrize(("lat_deg", "lon_deg"), [(47.4, 8.5), (-35.4, 149.2), (0.0, -179.9), (70.0, 20.0)])
def test_tiles_fit_the_local_frame(lat_deg: float, lon_deg: float) -> None:
    """A point 300 m away is where web Mercator has it, to a third of a percent."""
    frame = LocalFrame(lat_deg, lon_deg)
    layer = map_tiles.tile_source(frame)
    lat, lon = (float(degrees) for degrees in frame.to_degrees([300.0, 200.0]))
    zoom = 19
    share = (
        (lon + 180) / 360 * 2**zoom,
        (1 + math.asinh(math.tan(math.radians(lat))) / math.pi) / 2 * 2**zoom,
    )
    metre_per_px = layer.initial_resolution / 2**zoom
    east_m = share[0] * 256 * metre_per_px - layer.x_origin_offset
    north_m = share[1] * 256 * metre_per_px - layer.y_origin_offset
    assert east_m == pytest.approx(200, rel=0.007)
    assert north_m == pytest.approx(300, rel=0.007)


def test_the_probe_is_set_if_the_host_answers() -> None:
    """A refused connection is no answer."""
    with socket.create_server(("127.0.0.1", 0)) as host:
        assert map_tiles.probe("127.0.0.1", host.getsockname()[1]).wait(10)
        closed_port = host.getsockname()[1]
    assert not map_tiles.probe("127.0.0.1", closed_port).wait(0.2)
