"""A recording is a telemetry log like any ground station's."""

from __future__ import annotations

import os
import struct
import threading
import time
from pathlib import Path

import pytest
from pymavlink import mavutil

from flight_replay.exceptions import VehicleError
from flight_replay.logs.read_log import read_log
from flight_replay.logs.tlog.writer import QUEUED_FRAMES, Recorder
from flight_replay.mavlink import dialect

MAV = dialect.MAVLink(None, 1, 1)


def position(i: int) -> bytes:
    """A position frame."""
    message = dialect.MAVLink_global_position_int_message(
        1000 * i, 473977420 + 100 * i, 85455940, 500000, 12000, 100, 0, 0, 9000
    )
    return bytes(message.pack(MAV))


def test_each_frame_follows_its_stamp(tmp_path: Path) -> None:
    """Eight bytes of microseconds, big endian, then the frame."""
    with Recorder(tmp_path / "a.tlog", lambda: 1700000000.25) as recorder:
        recorder.write(b"frame")
    assert (tmp_path / "a.tlog").read_bytes() == struct.pack(">Q", 1700000000250000) + b"frame"


def test_a_clock_set_back_does_not_turn_stamps_round(tmp_path: Path) -> None:
    """Stamps never fall."""
    times = iter([5.0, 3.0, 6.0])
    with Recorder(tmp_path / "a.tlog", lambda: next(times)) as recorder:
        for _ in range(3):
            recorder.write(b"")
    stamps = [n for (n,) in struct.iter_unpack(">Q", (tmp_path / "a.tlog").read_bytes())]
    assert stamps == [5_000_000, 5_000_000, 6_000_000]


def test_pymavlink_and_this_program_read_it(tmp_path: Path) -> None:
    """The positions come back from both readers."""
    path = tmp_path / "a.tlog"
    with Recorder(path) as recorder:
        for i in range(1, 21):
            recorder.write(position(i))
    log = mavutil.mavlink_connection(str(path))
    found = []
    while (message := log.recv_match(type="GLOBAL_POSITION_INT")) is not None:
        found.append(message.lat)
    log.close()
    assert found == [473977420 + 100 * i for i in range(1, 21)]
    assert len(read_log(path).track) == 20


def test_threads_write_whole_frames(tmp_path: Path) -> None:
    """Frames of two threads do not mix."""
    path = tmp_path / "a.tlog"
    with Recorder(path) as recorder:
        frames = [position(i) for i in range(1, 200)]

        def write_all() -> None:
            for frame in frames:
                recorder.write(frame)

        threads = [threading.Thread(target=write_all) for _ in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    size = 8 + len(position(1))
    data = path.read_bytes()
    assert len(data) == 2 * 199 * size
    assert all(data[i + 8] == 0xFD for i in range(0, len(data), size))


def test_what_comes_after_the_end_is_left_out(tmp_path: Path) -> None:
    """The link may still hear something while the file is closed."""
    recorder = Recorder(tmp_path / "a.tlog")
    recorder.close()
    recorder.write(b"late")
    assert (tmp_path / "a.tlog").read_bytes() == b""


def test_a_file_that_cannot_be_written_is_told_before_anything_flies(tmp_path: Path) -> None:
    """The error names the file and the option."""
    with pytest.raises(VehicleError, match="choose another folder"):
        Recorder(tmp_path / "no" / "such" / "folder.tlog")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
@pytest.mark.parametrize("frames", [1, 2000], ids=["at the end", "on the way"])
def test_a_full_disk_does_not_end_a_flight(frames: int) -> None:
    """What cannot be kept is given up, and told afterwards."""
    with Recorder(Path("/dev/full")) as recorder:
        for i in range(frames):
            recorder.write(position(i))
    assert recorder.problem == "recording /dev/full is incomplete: No space left on device"


def test_an_error_that_nobody_foresaw_is_told_as_well(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not only those of the operating system leave frames out."""

    def fails(_value: object) -> None:
        raise ValueError("I/O operation on closed file")

    with Recorder(tmp_path / "a.tlog") as recorder:
        monkeypatch.setattr(recorder._file, "write", fails)
        recorder.write(b"a frame")
    assert recorder.problem is not None
    assert "I/O operation on closed file" in recorder.problem


def test_a_file_that_is_there_stays_until_the_recording_is_whole(tmp_path: Path) -> None:
    """The log that is replayed may be the file that is recorded to: it is read to its end first."""
    path = tmp_path / "a.tlog"
    path.write_bytes(b"before")
    with Recorder(path, lambda: 0.0) as recorder:
        recorder.write(b"after")
        assert path.read_bytes() == b"before"
    assert path.read_bytes() == bytes(8) + b"after"
    assert list(tmp_path.iterdir()) == [path]


def test_a_recording_that_cannot_have_its_name_is_kept(tmp_path: Path) -> None:
    """A folder of that name that came up meanwhile: the problem names the file that holds it."""
    path = tmp_path / "a.tlog"
    path.mkdir()
    with Recorder(path, lambda: 0.0) as recorder:
        recorder.write(b"a frame")
    (unfinished,) = tmp_path.glob("a.unfinished-*.tlog")
    assert unfinished.read_bytes() == bytes(8) + b"a frame"
    assert recorder.problem is not None
    assert str(unfinished) in recorder.problem


def test_a_recording_is_there_to_see_while_it_is_made(tmp_path: Path) -> None:
    """Should the program be killed, what was recorded up to then is left beside the file."""
    path = tmp_path / "flight.tlog"
    with Recorder(path) as recorder:
        recorder.write(b"a frame")
        (unfinished,) = tmp_path.glob("flight.unfinished-*.tlog")
        give_up_s = time.monotonic() + 20.0
        while not unfinished.stat().st_size and time.monotonic() < give_up_s:
            time.sleep(0.01)
        assert unfinished.read_bytes()[8:] == b"a frame"
    assert [each.name for each in tmp_path.iterdir()] == ["flight.tlog"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
def test_a_pipe_that_nobody_reads_holds_nothing_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Writing and closing return at once; the recorder says that frames are missing."""
    monkeypatch.setattr("flight_replay.logs.tlog.writer._CLOSE_S", 0.2)
    path = tmp_path / "pipe"
    os.mkfifo(path)
    recorder = Recorder(path)
    began_s = time.monotonic()
    for _ in range(QUEUED_FRAMES + 10):
        recorder.write(b"frame")
    recorder.close()
    assert time.monotonic() - began_s < 10
    assert recorder.problem is not None
    assert "could not be written" in recorder.problem


def test_a_slow_disk_leaves_a_recording_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Even if frames did not fit when it was closed."""
    monkeypatch.setattr("flight_replay.logs.tlog.writer.QUEUED_FRAMES", 5)
    free, begun = threading.Event(), threading.Event()
    recorder = Recorder(tmp_path / "a.tlog")
    append = recorder._append

    def slow(record: bytes) -> None:
        begun.set()
        free.wait(60)
        append(record)

    monkeypatch.setattr(recorder, "_append", slow)
    recorder.write(b"frame")
    assert begun.wait(60)
    for _ in range(100):
        recorder.write(b"frame")
    threading.Timer(0.05, free.set).start()
    recorder.close()
    assert [each.name for each in tmp_path.iterdir()] == ["a.tlog"]
    assert recorder.problem is not None
    assert "frames came faster than could be written" in recorder.problem


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
def test_frames_that_do_not_fit_are_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A disk that was too slow for a while makes a recording with gaps, which is told."""
    monkeypatch.setattr("flight_replay.logs.tlog.writer.QUEUED_FRAMES", 5)
    path = tmp_path / "pipe"
    os.mkfifo(path)
    recorder = Recorder(path)
    for _ in range(100):
        recorder.write(b"frame")
    with path.open("rb") as reader:
        recorder.close()
        written = len(reader.read()) // len(b"12345678frame")
    assert written <= 7
    assert recorder.problem is not None
    assert f"{100 - written} frames came faster than could be written" in recorder.problem
