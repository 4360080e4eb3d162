"""OpenStreetMap tiles below a chart in local metres, shown only if the tile server answers quickly.

Tiles are laid out in web Mercator metres, which are too long by 1 / cos(latitude). Scaled and shifted,
they fit the local frame to a third of a percent: 1 m at 300 m from its origin.
"""

from __future__ import annotations

import math
import socket
import threading

from bokeh.models import WMTSTileSource

from flight_replay.geometry.geodesy import EQUATORIAL_RADIUS_M, LocalFrame

HOST = "tile.openstreetmap.org"
URL = f"https://{HOST}/{{Z}}/{{X}}/{{Y}}.png"
ATTRIBUTION = "&copy; OpenStreetMap contributors"
_MAX_ZOOM = 19
_TILE_PX = 256
_PROBE_TIMEOUT_S = 1.5


def probe(host: str = HOST, port: int = 443) -> threading.Event:
    """Connect to the host in another thread; the event is set if it answers in time."""
    answered = threading.Event()

    def connect() -> None:
        try:
            socket.create_connection((host, port), _PROBE_TIMEOUT_S).close()
        except OSError:
            return
        answered.set()

    threading.Thread(target=connect, name="flight-replay tiles", daemon=True).start()
    return answered


def tile_source(frame: LocalFrame) -> WMTSTileSource:
    """OpenStreetMap's tiles in metres east and north of the frame's origin."""
    lat, lon = math.radians(frame.lat_deg), math.radians(frame.lon_deg)
    scale = math.cos(lat)
    half_turn_m = math.pi * EQUATORIAL_RADIUS_M
    x_m = EQUATORIAL_RADIUS_M * lon
    y_m = EQUATORIAL_RADIUS_M * math.asinh(math.tan(lat))
    return WMTSTileSource(
        url=URL,
        attribution=ATTRIBUTION,
        tile_size=_TILE_PX,
        max_zoom=_MAX_ZOOM,
        initial_resolution=2 * half_turn_m / _TILE_PX * scale,
        x_origin_offset=scale * (half_turn_m + x_m),
        y_origin_offset=scale * (half_turn_m + y_m),
    )
