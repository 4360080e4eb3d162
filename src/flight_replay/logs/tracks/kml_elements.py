"""The points of a KML file: of its tracks, of its placemarks with a time, and of its lines."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Sequence
from itertools import zip_longest

from flight_replay.logs.tracks.text_values import number, unix_time_s
from flight_replay.logs.tracks.track_points import PointCollector

OUR_TRACK = "Recorded track"
"""The name of the recorded track in the files that this program saves."""
OUR_HOME = "Home"
"""The name of home in them."""
OUR_FLOWN_TRACK = "Flown by flight-replay"
"""The name of what a replay flew, in those that were saved with one: it is not the recording."""
_LONGEST_PLACE = 256
_NAN = float("nan")
_GEOMETRIES = ("Track", "LineString", "Point")


class KmlReader:
    """Collects points.

    ``lines`` are numbered as tracks, ``our_track`` is the number of the one that we saved; ``is_clamped``
    tells whether there are heights that do not count, as KML has it by default.
    """

    def __init__(self, name: str) -> None:
        self.tracks, self.points, self.lines = (PointCollector(name) for _ in range(3))
        self.our_track: int | None = None
        self.is_clamped = False
        self._open: list[str] = []
        self._placemark, self._when, self._number = "", "", 0
        self._geometry, self._mode = _Geometry(), ""
        self._home_amsl_m = _NAN

    def __len__(self) -> int:
        return len(self.tracks) + len(self.points) + len(self.lines) + len(self._geometry)

    @property
    def home_amsl_m(self) -> float:
        """The height of home above the sea, where we saved the file and it tells it; else not a number."""
        return _NAN if self.our_track is None else self._home_amsl_m

    def start(self, name: str, _attributes: dict[str, str]) -> None:
        """A placemark, a geometry or a part of one begins."""
        parent = self._open[-1] if self._open else ""
        self._open.append(name)
        if name == "Placemark":
            self._placemark = self._when = ""
        elif name == "Track" and parent == "MultiTrack":
            self.tracks.begin_segment()
        elif name == "Track":
            self.tracks.begin_track()
        elif name == "LineString":
            self.lines.begin_track()
            self._number += 1
        elif name == "MultiTrack":
            self._mode = ""
        if name in _GEOMETRIES:
            self._geometry = _Geometry(self._mode if parent == "MultiTrack" else "")

    def text(self, text: str) -> bool:
        """Take a piece of coordinates, of which there may be many."""
        if self._open[-1:] != ["coordinates"]:
            return False
        if self._open[-2:-1] in (["LineString"], ["Point"]):
            self._geometry.take_coordinates(text)
        return True

    def end(self, name: str, text: str) -> None:
        """A placemark, a geometry or a part of one ends."""
        self._open.pop()
        parent = self._open[-1] if self._open else ""
        if parent in _GEOMETRIES:
            self._geometry.take(name, text)
        elif parent == "MultiTrack" and name == "altitudeMode":
            self._mode = text.strip()
        elif parent == "Placemark" and name == "name":
            self._placemark = text.strip()
        elif parent == "TimeStamp" and name == "when":
            self._when = text
        if name in ("Track", "LineString"):
            self._add(name)
        elif name == "Placemark":
            self._add("Point")

    def finish(self) -> None:
        """Take what of a track or a line was read before a fault."""
        for name in ("Track", "LineString"):
            if name in self._open:
                self._add(name)

    def _add(self, name: str) -> None:
        """Add the points of the last geometry, if it is of that name."""
        geometry, self._geometry = self._geometry, _Geometry()
        if self._placemark == OUR_FLOWN_TRACK:
            return
        if name == "Track":
            self._add_all(self.tracks, geometry, geometry.times_s)
        elif name == "LineString":
            self._add_all(self.lines, geometry, ())
            if self._placemark == OUR_TRACK:
                self.our_track = self._number
        elif self._placemark == OUR_HOME and geometry.mode == "absolute":
            self._home_amsl_m = next((height_m for _, _, height_m in geometry.places()), _NAN)
        elif self._when:
            self._add_all(self.points, geometry, [unix_time_s(self._when)])

    def _add_all(self, to: PointCollector, geometry: _Geometry, times_s: Sequence[float]) -> None:
        rows = zip_longest(geometry.places(), times_s, geometry.headings_deg, fillvalue=None)
        for place, time_s, heading_deg in rows:
            if place is None:
                break
            lon_deg, lat_deg, height_m = place
            self.is_clamped |= geometry.is_clamped and abs(height_m) > 0
            to.add(
                lat_deg,
                lon_deg,
                utc_s=_NAN if time_s is None else time_s,
                amsl_m=height_m if geometry.mode == "absolute" else _NAN,
                alt_m=height_m if geometry.mode == "relativeToGround" else _NAN,
                heading_deg=_NAN if heading_deg is None else heading_deg,
            )


class _Geometry:
    """What was read of a track, a line or a point: its places as longitude, latitude, height."""

    def __init__(self, mode: str = "") -> None:
        self.mode = mode
        self.times_s, self.headings_deg = array("d"), array("d")
        self._numbers = array("d")
        self._rest = ""

    def __len__(self) -> int:
        return len(self._numbers) // 3 + len(self.times_s) + len(self.headings_deg)

    @property
    def is_clamped(self) -> bool:
        """Whether the heights do not count."""
        return self.mode not in ("absolute", "relativeToGround")

    def places(self) -> Iterator[tuple[float, float, float]]:
        """All places."""
        return zip(*[iter(self._numbers)] * 3, strict=False)

    def take(self, name: str, text: str) -> None:
        """Take a part of the geometry that has ended."""
        if name == "altitudeMode":
            self.mode = text.strip()
        elif name == "when":
            self.times_s.append(unix_time_s(text))
        elif name == "coord":
            self._add_place(text.split())
        elif name == "angles":
            self.headings_deg.append(number((text.split() or [""])[0]))
        elif name == "coordinates":
            self.take_coordinates(" ")

    def take_coordinates(self, text: str) -> None:
        """Take a piece of coordinates, whose last place may go on in the next piece."""
        text = self._rest + text
        places = text.split()
        ends = not places or text[-1].isspace()
        self._rest = "" if ends else places.pop()[:_LONGEST_PLACE]
        for place in places:
            self._add_place(place.split(","))

    def _add_place(self, values: Sequence[str]) -> None:
        numbers = [number(value) for value in values[:3]]
        self._numbers.extend(numbers + [_NAN] * (3 - len(numbers)))
