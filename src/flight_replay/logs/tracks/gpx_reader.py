"""GPX 1.0 and 1.1 (topografix.com/GPX): the points of its tracks, or of its routes where there is no track.

Elevations are above mean sea level. A route has no times. Speed and course are elements of a point in
GPX 1.0, and of Garmin's TrackPointExtension in 1.1, in m/s and degrees.
"""

from __future__ import annotations

import math

from flight_replay.logs.byte_source import OpenLog, Progress
from flight_replay.logs.recording import Recording
from flight_replay.logs.tracks.byte_pieces import LogPieces
from flight_replay.logs.tracks.text_values import number, unix_time_s
from flight_replay.logs.tracks.track_points import PointCollector
from flight_replay.logs.tracks.track_recording import TrackFile, track_recording
from flight_replay.logs.tracks.xml_events import read_xml
from flight_replay.logs.vehicles import VehicleId

OUR_CREATOR, OUR_HOME = "flight-replay", "Home"
"""How files that this program saves call it, and the way point at home."""
_PARTS = {
    "": ("ele", "time", "speed", "course", "name"),
    "extensions/TrackPointExtension": ("speed", "course"),
}
"""What is read of a point, by the elements around it."""


def read_gpx(log: OpenLog, _vehicle: VehicleId | None, progress: Progress | None) -> Recording:
    """Read a GPX file; see ``log_formats.Read``."""
    reader = _GpxReader(log.name)
    end = read_xml(LogPieces(log, progress), reader, log.name)
    notes = list(end.notes())
    points = reader.track if len(reader.track) else reader.route
    if points is reader.route and len(points):
        notes.append("It has no track, but a route, which is taken for one")
    file = TrackFile(name=log.name, bytes=end.bytes, notes=notes, home_amsl_m=reader.home_amsl_m)
    return track_recording(points.points(), file)


class _GpxReader:
    """Collects the points of tracks and routes, and the height of home above the sea in files of our own."""

    def __init__(self, name: str) -> None:
        self.track, self.route = PointCollector(name), PointCollector(name)
        self.home_amsl_m = math.nan
        self._is_ours = False
        self._point: dict[str, str] | None = None
        self._inside: list[str] = []  # elements of the point that are open

    def __len__(self) -> int:
        return len(self.track) + len(self.route)

    def start(self, name: str, attributes: dict[str, str]) -> None:
        """A track, a segment, a point or a part of one begins."""
        if self._point is not None:
            self._inside.append(name)
        elif name in ("trkpt", "rtept", "wpt"):
            self._point, self._inside = dict(attributes), []
        elif name == "gpx":
            self._is_ours = attributes.get("creator") == OUR_CREATOR
        elif name == "trk":
            self.track.begin_track()
        elif name == "trkseg":
            self.track.begin_segment()
        elif name == "rte":
            self.route.begin_track()

    def end(self, name: str, text: str) -> None:
        """A point or a part of one ends."""
        point = self._point
        if point is None:
            return
        if self._inside:
            self._inside.pop()
            if name in _PARTS.get("/".join(self._inside), ()):
                point[name] = text
            return
        self._point = None
        if name == "wpt":
            if self._is_ours and point.get("name") == OUR_HOME:
                self.home_amsl_m = number(point.get("ele"))
            return
        speed_m_s, course_rad = number(point.get("speed")), math.radians(number(point.get("course")))
        (self.track if name == "trkpt" else self.route).add(
            number(point.get("lat")),
            number(point.get("lon")),
            utc_s=unix_time_s(point.get("time")),
            amsl_m=number(point.get("ele")),
            north_m_s=speed_m_s * math.cos(course_rad),
            east_m_s=speed_m_s * math.sin(course_rad),
        )

    def text(self, _text: str) -> bool:
        """No text is taken piece by piece."""
        return False
