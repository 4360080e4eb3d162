"""What is read from a log: vehicles, fixes, arming, sources, and what is said of files that are no logs."""

from __future__ import annotations

import bz2
import gzip
import io
import lzma
import os
import re
import sys
import threading
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flight_replay.exceptions import LogError
from flight_replay.logs import byte_source
from flight_replay.logs.read_log import read_log
from flight_replay.logs.recording import Recording
from flight_replay.logs.tlog import scan as scan_module
from flight_replay.logs.track import Armed
from flight_replay.logs.vehicles import VehicleCount, VehicleId
from tests.helpers.log_writer import START_US, LogWriter, frame, position_payload
from tests.helpers.paths import other_log

COUNTS = {  # GLOBAL_POSITION_INT of the vehicle, and how many are empty
    "dronekit-flight.tlog": {(1, 1): (2833, 149)},
    "arducopter-4.6-pilot.tlog": {(1, 1): (2717, 30)},
    "wild/three-boots.tlog": {(10, 1): (1151, 108)},
    "wild/near-zero-then-teleport.tlog": {(1, 1): (247, 7)},
    "wild/six-armings.tlog": {(1, 1): (782, 10)},
    "wild/unstamped.rlog": {(1, 1): (783, 10)},
    "wild/five-vehicles-overwritten.tlog": {
        (2, 1): (266, 13),
        (4, 1): (62, 0),
        (3, 1): (14, 2),
        (1, 1): (8, 0),
        (5, 1): (4, 0),
    },
    "wild/mixed-versions.tlog": {(1, 1): (268, 12)},
}


def write(tmp_path: Path, log: LogWriter | bytes, name: str = "made.tlog") -> Path:
    """A log as a file."""
    path = tmp_path / name
    path.write_bytes(log if isinstance(log, bytes) else log.data)
    return path


def flight(log: LogWriter, fixes: int = 20, start_ms: int = 10_000) -> LogWriter:
    """Append fixes 0.25 s apart that go north at 4 m/s."""
    for fix in range(fixes):
        log.position(start_ms + 250 * fix, 47.4 + fix * 9e-6, 8.5, 10.0, velocity=(4.0, 0.0, 0.0))
    return log


def rejected(log: Recording) -> int:
    return sum(log.rejected.values())


@pytest.mark.parametrize("name", COUNTS)
def test_the_counts_of_real_logs_come_out(name: str) -> None:
    """Every vehicle's usable, empty and rejected positions add up to what a strict reader counted."""
    path = other_log(name)
    for (system, component), (records, empty) in COUNTS[name].items():
        log = read_log(path, vehicle=VehicleId(system, component))
        assert log.without_position == empty
        assert len(log.track) + empty + rejected(log) == records
    assert len(read_log(path).vehicles) == len(COUNTS[name])


def test_the_dronekit_log_is_read_whole() -> None:
    """DroneKit's log gives 2684 fixes of vehicle 1:1 in two boots, and nothing to reject."""
    log = read_log(other_log("dronekit-flight.tlog"))
    assert log.vehicle == VehicleCount(1, 1, 2684)
    assert log.bytes == 2_723_840
    assert log.rejected == {}
    assert np.flatnonzero(np.diff(log.track.boot)).tolist() == [490]
    assert (np.diff(log.track.time_s) >= 0).all()


@pytest.mark.parametrize("version", [1, 2])
def test_columns_are_in_si_units(tmp_path: Path, version: int) -> None:
    """Degrees, metres above home and sea level, and metres per second north, east and up."""
    log = LogWriter(version=version).position(
        5_250, -35.3632621, 149.1652374, 12.345, velocity=(1.5, -2.25, 0.5)
    )
    track = read_log(write(tmp_path, log)).track
    assert len(track) == 1
    got = [float(getattr(track, name)[0]) for name in ("time_s", "lat_deg", "lon_deg", "alt_m", "amsl_m")]
    assert got == pytest.approx([5.25, -35.3632621, 149.1652374, 12.345, 412.345], abs=1e-9)
    assert (track.north_m_s[0], track.east_m_s[0], track.up_m_s[0]) == (1.5, -2.25, 0.5)
    assert track.armed.tolist() == [Armed.UNKNOWN]


def test_trimmed_payloads_are_filled_up(tmp_path: Path) -> None:
    """A MAVLink 2 position whose velocity and heading were trimmed off is read with zeros for them."""
    trimmed = frame(33, position_payload(7, 47.0, 8.0, 1.0, heading_deg=0))
    assert len(trimmed) < 12 + 28
    track = read_log(write(tmp_path, trimmed)).track
    assert (track.lat_deg[0], track.alt_m[0], track.north_m_s[0]) == (47.0, 1.0, 0.0)


@pytest.mark.parametrize("version", [1, 2])
def test_headings_are_degrees_or_unknown(tmp_path: Path, version: int) -> None:
    """A heading counts from 0 to below 360; 65535, for none, is not a number and costs no fix."""
    log = LogWriter(version=version)
    for at, heading_deg in enumerate((0.0, 123.45, 359.99, 360.0, 655.35, 400.0)):
        log.add(33, position_payload(1000 + 250 * at, heading_deg=heading_deg))
    headings = read_log(write(tmp_path, log)).track.heading_deg
    assert headings.tolist() == pytest.approx([0.0, 123.45, 359.99, 0.0, np.nan, np.nan], nan_ok=True)


def test_vehicles_are_not_mixed_and_the_fullest_is_chosen(tmp_path: Path) -> None:
    """Each system and component id is a vehicle of its own, listed by usable fixes."""
    log = flight(LogWriter(), 5)
    flight_of_seven = flight(LogWriter(system=7, component=3), 9)
    path = write(tmp_path, bytes(log.data + flight_of_seven.data))
    read = read_log(path)
    assert [(each.system, each.component, each.fixes) for each in read.vehicles] == [(7, 3, 9), (1, 1, 5)]
    assert (read.vehicle, len(read.track)) == (VehicleCount(7, 3, 9), 9)
    assert len(read_log(path, vehicle=VehicleId(1)).track) == 5
    assert len(read_log(path, vehicle=VehicleId(7, 3)).track) == 9


@pytest.mark.parametrize(("vehicle_type", "autopilot"), [(6, 8), (5, 3), (18, 8)])
def test_what_is_no_vehicle_is_not_chosen(tmp_path: Path, vehicle_type: int, autopilot: int) -> None:
    """Ground stations, antenna trackers and companion computers send where they are, and more often."""
    log = flight(LogWriter().heartbeat(), 5)
    other = flight(LogWriter(system=255).heartbeat(vehicle_type=vehicle_type, autopilot=autopilot), 9)
    unknown = flight(LogWriter(component=9), 7)
    path = write(tmp_path, bytes(other.data + unknown.data + log.data))
    assert [each.fixes for each in read_log(path).vehicles] == [5, 7, 9]
    assert read_log(path).vehicle == VehicleCount(1, 1, 5)
    assert read_log(path, vehicle=VehicleId(255)).vehicle == VehicleCount(255, 1, 9)


def test_a_vehicle_that_is_not_there_is_told_with_those_that_are(tmp_path: Path) -> None:
    """Asking for another vehicle names the ones to choose from."""
    path = write(tmp_path, flight(LogWriter(), 5))
    with pytest.raises(
        LogError, match=r"no positions of vehicle 9; choose with --vehicle from 1:1 \(5 fixes\)"
    ):
        read_log(path, vehicle=VehicleId(9))
    with pytest.raises(LogError, match="no positions of vehicle 1:2; choose"):
        read_log(path, vehicle=VehicleId(1, 2))
    empty = flight(LogWriter(), 5).data + LogWriter(system=3).empty(100).data
    with pytest.raises(LogError, match="vehicle 3:1: 1 empty record; choose with --vehicle from 1:1"):
        read_log(write(tmp_path, bytes(empty)), vehicle=VehicleId(3))


@pytest.mark.parametrize(
    "spoof",
    [
        {"vehicle_type": 6, "autopilot": 8},
        {"vehicle_type": 18, "autopilot": 8},
        {"vehicle_type": 26, "autopilot": 3},
        {"vehicle_type": 2, "autopilot": 0},
        {"system": 255, "component": 190},
        {"system": 51, "component": 68},
        {"component": 154},
    ],
    ids=["station", "companion", "gimbal", "other autopilot", "other system", "radio", "other component"],
)
def test_only_the_autopilots_heartbeats_tell_of_arming(tmp_path: Path, spoof: dict[str, int]) -> None:
    """Disarmed heartbeats of others between an armed autopilot's change nothing."""
    log = LogWriter().heartbeat(armed=True)
    for fix in range(6):
        log.heartbeat(False, **spoof).position(1_000 + fix * 250)
    assert read_log(write(tmp_path, log)).track.armed.tolist() == [Armed.YES] * 6


def test_heartbeats_of_an_unknown_autopilot_count_where_there_are_no_others(tmp_path: Path) -> None:
    """A vehicle under another autopilot than ArduPilot is told armed by its own heartbeats."""
    log = LogWriter().position(0).heartbeat(True, 2, 12).position(250).heartbeat(False, 2, 12)
    log.position(500).position(750)
    log.heartbeat(True, 2, 0).position(1_000)
    armed = read_log(write(tmp_path, log)).track.armed.tolist()
    assert armed == [Armed.UNKNOWN, Armed.YES, Armed.YES, Armed.NO, Armed.NO]
    generic = LogWriter().position(0).heartbeat(True, 2, 0).position(250)
    assert read_log(write(tmp_path, generic)).track.armed.tolist() == [Armed.UNKNOWN, Armed.YES]


def test_the_fix_at_which_disarming_is_seen_belongs_to_the_flight(tmp_path: Path) -> None:
    """Armed means armed at any time since the fix before, but not across a reboot."""
    log = LogWriter().heartbeat(False).position(0).heartbeat(True).position(250).heartbeat(False)
    log.position(500).position(750).heartbeat(True).position(60_000).heartbeat(False).position(1_000)
    track = read_log(write(tmp_path, log)).track
    assert track.armed.tolist() == [0, 1, 1, 0, 1, 0]
    assert track.boot.tolist() == [0, 0, 0, 0, 0, 1]


def test_a_vehicle_that_booted_in_flight_is_not_flying(tmp_path: Path) -> None:
    """The word of the boot before says nothing, and what comes ahead of the first new word is not known."""
    log = LogWriter().heartbeat(True).position(60_000).heartbeat(True).position(60_250).heartbeat(True)
    log.position(4_000).position(4_250).heartbeat(False).position(4_500).heartbeat(True).position(4_750)
    track = read_log(write(tmp_path, log)).track
    assert track.armed.tolist() == [1, 1, -1, -1, 0, 1]
    assert track.boot.tolist() == [0, 0, 1, 1, 1, 1]
    log.position(3_000).position(3_250)
    assert read_log(write(tmp_path, log)).track.armed.tolist() == [1, 1, -1, -1, 0, 1, -1, -1]
    log.heartbeat(True).position(3_500)
    assert read_log(write(tmp_path, log)).track.armed.tolist() == [1, 1, -1, -1, 0, 1, 1, 1, 1]


def test_positions_that_come_late_do_not_move_the_arming(tmp_path: Path) -> None:
    """Of a log that holds a second link's copies 2.75 s behind, the flight is that of the first link."""
    log = LogWriter()
    for step in range(60):
        log.heartbeat(12 <= step < 36).position(10_000 + 250 * step)
        if step >= 11:
            log.position(10_000 + 250 * (step - 11))
    track = read_log(write(tmp_path, log)).track
    armed_s = track.time_s[track.armed == Armed.YES]
    assert (armed_s[0], armed_s[-1]) == (pytest.approx(13.0, abs=0.25), pytest.approx(19.0, abs=0.25))
    assert np.count_nonzero(np.diff(track.armed)) == 2


def test_without_position_and_rejected_are_counted(tmp_path: Path) -> None:
    """Empty records and implausible ones are left out and counted, each by its kind."""
    log = flight(LogWriter().empty(100).empty(350), 10)
    log.position(13_000, 0.005, -0.004).position(13_250, 91.0, 8.5).position(13_500, 47.4, 8.5)
    read = read_log(write(tmp_path, log))
    assert (len(read.track), read.without_position) == (11, 2)
    assert read.rejected == {"near 0,0": 1, "outside the globe": 1}
    assert read.rejected_total == 2


def test_long_runs_of_empty_positions_are_counted_but_not_kept(tmp_path: Path) -> None:
    """Of thousands of empty positions in a row hardly one takes memory, and the clock's falls stay known."""
    log = LogWriter()
    for record in range(3_000):
        log.empty(1_000 + record).gps(1).heartbeat(False)
    log.empty(500)
    flight(log.gps(3), 4, 2_000)
    records, _ = scan_module.scan(_opened(bytes(log.data)))
    assert records.empty == {257: 3_001}
    assert len(records.positions) < 12
    assert len(records.heartbeats) + len(records.gps) < 12


def test_boots_without_a_position_leave_no_mark_on_the_track(tmp_path: Path) -> None:
    """Time begins with the clock of the first fix, and boots are counted from its boot."""
    log = flight(LogWriter().empty(90_000).empty(90_250).empty(500), 4, 2_000)
    log.stamp_us = START_US + 70_000_000
    track = read_log(write(tmp_path, flight(log, 4, 1_000))).track
    assert track.time_s.tolist() == pytest.approx([2.0, 2.25, 2.5, 2.75, 72.75, 73.0, 73.25, 73.5])
    assert track.boot.tolist() == [0] * 4 + [1] * 4


def _opened(data: bytes) -> Any:
    return byte_source.OpenLog("made", io.BytesIO(data))


@pytest.mark.parametrize("cut", [0, 1, 300, 5_000])
def test_packed_logs_are_read_as_they_are(tmp_path: Path, cut: int) -> None:
    """A .gz log gives the same fixes; of one whose end is missing, those up to there."""
    data = bytes(flight(LogWriter(), 4_000).data)
    packed = gzip.compress(data[:50_000], 1) + gzip.compress(data[50_000:], 1)
    path = write(tmp_path, packed[: len(packed) - cut], "made.tlog.gz")
    read = read_log(path)
    assert read.bytes <= len(data)
    assert len(read.track) == 4_000 if cut < 2 else 3_000 < len(read.track) < 4_000
    assert (read.notes == ()) == (cut == 0)


@pytest.mark.parametrize("behind", [b"", b"\0" * 512, b"left by another program"])
def test_damaged_packed_logs_are_read_up_to_the_damage(tmp_path: Path, behind: bytes) -> None:
    """What is before a fault in compressed data counts, what follows it is not guessed at."""
    data = bytes(flight(LogWriter(), 4_000).data)
    packed = gzip.compress(data[:100_000], 1)
    spoiled = packed[:-8] + bytes([packed[-8] ^ 0xFF]) + packed[-7:]  # the checksum behind the data
    read = read_log(write(tmp_path, spoiled + gzip.compress(data[100_000:]) + behind))
    assert read.bytes == 100_000
    assert read.notes == ("Its gzip data is damaged or cut off: the rest of the log cannot be read",)
    read = read_log(write(tmp_path, packed + gzip.compress(data[100_000:]) + behind))
    assert (read.bytes, len(read.track), read.notes) == (len(data), 4_000, ())


def test_torn_packed_logs_are_unpacked_to_their_last_byte() -> None:
    """However few bytes are asked for at a time, all come that the packed ones tell."""
    packed = gzip.compress(bytes(50_000))[:40]
    whole = zlib.decompressobj(wbits=31).decompress(packed)
    stream, got, piece = byte_source.OpenLog("made", io.BytesIO(packed)).stream, b"", bytearray(7)
    while length := stream.readinto(memoryview(piece)):
        got += piece[:length]
    assert len(got) == len(whole) > 10_000


def test_standard_input_is_read_by_a_dash(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """``-`` reads what comes in, packed or not, and says where it was from."""
    data = bytes(flight(LogWriter(), 50).data)
    for sent in (data, gzip.compress(data)):
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(sent)))
        read = read_log("-")
        assert (len(read.track), read.path, read.bytes) == (50, "standard input", len(data))


def test_a_closed_standard_input_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """A shell may close it (``<&-``): then there is nothing to read."""
    monkeypatch.setattr(sys, "stdin", None)
    with pytest.raises(LogError, match="standard input is closed; send a log to it, or name one"):
        read_log("-")


def test_a_standard_input_that_does_not_wait_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """A pipe that says "nothing yet" is read to its end all the same."""
    read_end, write_end = os.pipe()
    os.set_blocking(read_end, False)
    data = bytes(flight(LogWriter(), 500).data)

    set_blocking, asked = os.set_blocking, threading.Event()

    def ask(descriptor: int, blocking: bool) -> None:
        set_blocking(descriptor, blocking)
        asked.set()

    def send() -> None:
        with os.fdopen(write_end, "wb") as pipe:
            asked.wait(60)
            pipe.write(data)

    monkeypatch.setattr(os, "set_blocking", ask)
    sender = threading.Thread(target=send)
    with os.fdopen(read_end) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        sender.start()
        assert len(read_log("-").track) == 500
    sender.join(60)


def test_a_named_pipe_is_read_to_its_end(tmp_path: Path) -> None:
    """What is not a plain file is read as it comes."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    data = bytes(flight(LogWriter(), 500).data)
    writer = threading.Thread(target=pipe.write_bytes, args=(data,), daemon=True)
    writer.start()
    assert len(read_log(pipe).track) == 500
    writer.join(60)


def test_blocks_are_put_together_in_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A log of many blocks gives the same track as one of a single block, with progress to its end."""
    path = write(tmp_path, flight(LogWriter(version=1), 3_000))
    whole = read_log(path)
    monkeypatch.setattr(scan_module.scan, "__defaults__", (None, 10_000))
    told: list[tuple[int, int]] = []
    parts = read_log(path, progress=lambda done, total: told.append((done, total)))
    assert np.array_equal(whole.track.lat_deg, parts.track.lat_deg)
    assert whole.bytes == parts.bytes == path.stat().st_size
    assert told[-1] == (whole.bytes, whole.bytes)
    assert [done for done, _ in told] == sorted(done for done, _ in told)
    assert len(told) > 10


UTF16 = ("\ufeff" + "Build started 12.03.2019\r\n" * 40).encode("utf-16-le")


@pytest.mark.parametrize(
    ("content", "what"),
    [
        (b"", "is empty"),
        (UTF16, "is text in UTF-16"),
        (UTF16[2:], "is text in UTF-16"),
        (UTF16.decode("utf-16-le")[1:].encode("utf-16-be"), "is text in UTF-16"),
        ("Übersetzung\r\n".encode("utf-16-le"), "is text in UTF-16"),
        ("1>  Übersetzung läuft\n".encode(), "is text that holds no flight"),
        ("\ufeff1>  Übersetzung läuft\n".encode(), "is text that holds no flight"),
        (b'{\n  "fileType": "Plan",\n  "mission": {}}', "is a mission, not a recorded flight"),
        (b"a,b\n1,2\nlat,lon\n", "is text that holds no flight"),
        (b"time,lat,lon\n0,47.1,8.1\n", r'without the columns .*: kind \(the first, "track" .* AirData'),
        (b"Time;Latitude [deg];Longitude\n0;47.1;8.1\n", "without the columns"),
        (bytes(5_000), "holds no MAVLink position"),
        (b"\xfd\x09\0" * 170, "holds no MAVLink position"),
        (
            b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n",
            "is a git LFS pointer",
        ),
        (gzip.compress(b"nothing"), "is gzip data that holds no flight"),
        (bytes(range(256)) * 8, "holds no MAVLink position"),
        (bytes(LogWriter().heartbeat().gps(3).data), "without any GLOBAL_POSITION_INT"),
        (bytes(LogWriter().empty(1).empty(2).data), "vehicle 1:1: 2 empty records; name another log"),
        (
            bytes(LogWriter().empty(1).position(2, 0.001, 0.001).data),
            r"1 empty record, 1 rejected \(near 0,0\)",
        ),
    ],
    ids=[
        *(
            "empty",
            "utf-16",
            "utf-16 without mark",
            "utf-16 the other way round",
            "utf-16 not of ASCII",
            "text",
            "text with mark",
            "plan",
            "text with commas",
            "table",
            "table parted by semicolons",
            "zeros",
            "bytes that could be Bengali",
            "lfs",
            "gzip",
            "junk",
        ),
        *("no positions", "only empty", "only bad"),
    ],
)
def test_what_is_no_usable_log_is_told_in_one_sentence(tmp_path: Path, content: bytes, what: str) -> None:
    """The message names the file, says what it is and what to do."""
    path = write(tmp_path, content)
    with pytest.raises(LogError, match=what) as error:
        read_log(path)
    assert str(error.value).startswith(str(path))
    assert re.search("name (a|another) log", str(error.value))
    assert "\n" not in str(error.value)


def test_paths_that_cannot_be_read_are_told(tmp_path: Path) -> None:
    """Missing files, directories, devices and what is no file each get their sentence."""
    with pytest.raises(LogError, match=f"{os.devnull} is a device"):
        read_log(os.devnull)
    with pytest.raises(LogError, match="does not exist"):
        read_log(tmp_path / "missing.tlog")
    with pytest.raises(LogError, match="is a directory"):
        read_log(tmp_path)
    with pytest.raises(LogError, match=r"^\. is a directory"):
        read_log("")
    with pytest.raises(LogError, match=r"below cannot be read \(Not a directory\)"):
        read_log(write(tmp_path, b"") / "below")


class _Failing(io.BytesIO):
    """Bytes of which the last ones cannot be read."""

    def readinto(self, buffer: Any, /) -> int:
        got = super().readinto(buffer)
        if not got:
            raise OSError(5, "Input/output error")
        return got


def test_a_disk_that_fails_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An input error in the middle of a log is an expected failure."""
    failing = _Failing(flight(LogWriter(), 10).data)
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(failing))
    with pytest.raises(LogError, match=r"cannot be read \(Input/output error\); name a readable log"):
        read_log("-")


@pytest.mark.parametrize("bytes_left", [0, 100, 900, 1_200])
def test_a_file_that_shrinks_while_it_is_read_ends_there(tmp_path: Path, bytes_left: int) -> None:
    """Bytes that were there at the start and are gone are no error."""
    path = write(tmp_path, flight(LogWriter(), 200))

    def shrink(done: int, size: int) -> None:
        os.truncate(path, min(path.stat().st_size, 5_000 + bytes_left))

    with byte_source.open_log(path) as log:
        records, length = scan_module.scan(log, shrink, 1_000)
    assert 0 < len(records.positions) < 200
    assert length <= path.stat().st_size


def test_stamps_may_be_missing_or_wrong(tmp_path: Path) -> None:
    """Without stamps, or with nonsense for them, the fixes and their times are the same."""
    tracks = []
    for stamp_us in (None, START_US, 2**64 - 1):
        log = flight(flight(LogWriter(stamp_us=stamp_us), 5, 20_000), 5, 1_000)
        tracks.append(read_log(write(tmp_path, log)).track)
    for track in tracks:
        assert track.boot.tolist() == [0] * 5 + [1] * 5
        assert np.array_equal(track.time_s, tracks[0].time_s)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (lzma.compress(bytes(5_000)), "is packed with xz: unpack it first; name a log"),
        (bz2.compress(bytes(5_000)), "is packed with bzip2: unpack it first"),
        (b"\x28\xb5\x2f\xfd" + bytes(100), "is packed with zstd: unpack it first"),
        (b"7z\xbc\xaf\x27\x1c" + bytes(100), "is a 7z archive: unpack it first"),
        (b"Rar!\x1a\x07\0" + bytes(100), "is a RAR archive: unpack it first"),
        (b"QGC WPL 110\n0\t1\t0\t16", "is a mission, not a recorded flight"),
    ],
    ids=["xz", "bzip2", "zstd", "7z", "rar", "mission"],
)
def test_archives_and_missions_are_named(content: bytes, message: str, tmp_path: Path) -> None:
    """Pilots pack their logs, and mix up files."""
    with pytest.raises(LogError, match=message):
        read_log(write(tmp_path, content))


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["MAVLink", "old ArduPilot"])
def test_climbs_are_upward_whichever_way_the_firmware_sends_them(sign: float, tmp_path: Path) -> None:
    """The heights tell: 2 m/s up, then down."""
    log = LogWriter()
    for fix in range(80):
        up_m_s = 2.0 if fix < 40 else -2.0
        log.position(250 * fix, 47.4, 8.5, 20.0 - abs(fix - 40) / 2, velocity=(0.0, 0.0, sign * up_m_s))
    track = read_log(write(tmp_path, log)).track
    assert track.up_m_s.tolist() == [2.0] * 40 + [-2.0] * 40


def test_vertical_velocities_of_a_level_flight_are_left_as_they_are(tmp_path: Path) -> None:
    """Noise tells nothing."""
    log = LogWriter()
    for fix in range(40):
        log.position(250 * fix, 47.4, 8.5, 10.0 + fix % 2 / 100, velocity=(0.0, 0.0, 0.1 - fix % 2 / 5))
    assert read_log(write(tmp_path, log)).track.up_m_s.tolist() == [0.1, -0.1] * 20
