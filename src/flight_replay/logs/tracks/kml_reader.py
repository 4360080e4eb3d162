"""KML 2.2 and 2.3 (OGC 07-147r2, 12-007r2), and KMZ, a ZIP archive around it.

Of what one file may hold of a flight, often the same several times, the first of these is read: its
tracks with times (gx:Track), its points with a time each, its lines. One with less than half of the
points of another is something beside the flight, such as photographs.
"""

from __future__ import annotations

from collections.abc import Iterable

from flight_replay.logs.byte_source import OpenLog, Progress
from flight_replay.logs.recording import Recording
from flight_replay.logs.tracks.byte_pieces import LogPieces
from flight_replay.logs.tracks.kml_elements import KmlReader
from flight_replay.logs.tracks.kmz_archive import first_kml
from flight_replay.logs.tracks.longest_line import longest_line
from flight_replay.logs.tracks.track_recording import TrackFile, track_recording
from flight_replay.logs.tracks.xml_events import read_xml
from flight_replay.logs.vehicles import VehicleId


def read_kml(log: OpenLog, _vehicle: VehicleId | None, progress: Progress | None) -> Recording:
    """Read a KML file; see ``log_formats.Read``."""
    return _read(LogPieces(log, progress), log.name)


def read_kmz(log: OpenLog, _vehicle: VehicleId | None, progress: Progress | None) -> Recording:
    """Read the first KML file of a ZIP archive; see ``log_formats.Read``."""
    return _read(first_kml(LogPieces(log, progress), log.name), log.name)


def _read(pieces: Iterable[bytes], name: str) -> Recording:
    reader = KmlReader(name)
    end = read_xml(pieces, reader, name)
    notes = list(end.notes())
    reader.finish()
    kinds = reader.tracks, reader.points, reader.lines
    most = max(map(len, kinds))
    chosen = next(each for each in kinds if 2 * len(each) >= most)
    points = chosen.points()
    if chosen is reader.lines:
        points, left_out = longest_line(points, reader.our_track)
        notes += left_out
    if reader.is_clamped:
        notes.append("Its heights are not read: it says that it lies on the ground")
    file = TrackFile(name=name, bytes=end.bytes, notes=notes, home_amsl_m=reader.home_amsl_m)
    return track_recording(points, file)
