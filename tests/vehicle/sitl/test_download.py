"""dronekit-sitl's download, made safe: complete or not at all, in time, and never outside its folder."""

from __future__ import annotations

import gzip
import hashlib
import http.server
import io
import platform
import random
import socket
import subprocess
import sys
import tarfile
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from flight_replay.events import Event, Notice, Progress
from flight_replay.exceptions import SimulatorError
from flight_replay.vehicle.sitl import fetch, unpack
from flight_replay.vehicle.sitl.download import DownloadSource, download, dronekit_sitl_source

Answer = Callable[[http.server.BaseHTTPRequestHandler], object]


class StandIn:
    """A web server on loopback that gives one answer to everything."""

    def __init__(self) -> None:
        self.asked: list[str] = []
        self.answer: Answer = lambda handler: None
        outer = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                outer.asked.append(self.path)
                outer.answer(self)

            def log_message(self, format: str, *args: object) -> None:
                """Say nothing."""

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.server.daemon_threads = True
        self.thread = threading.Thread(
            target=self.server.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True
        )
        self.thread.start()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server.server_port}/sitl"

    def close(self) -> None:
        self.server.shutdown()
        self.server.server_close()
        self.thread.join()


@pytest.fixture
def web() -> Iterator[StandIn]:
    server = StandIn()
    yield server
    server.close()


def archive(*members: tuple[tarfile.TarInfo, bytes]) -> bytes:
    data = io.BytesIO()
    with tarfile.open(fileobj=data, mode="w:gz") as tar:
        for info, content in members:
            info.size = len(content)
            tar.addfile(info, io.BytesIO(content))
    return data.getvalue()


def member(
    name: str, content: bytes = b"binary", kind: bytes = tarfile.REGTYPE
) -> tuple[tarfile.TarInfo, bytes]:
    info = tarfile.TarInfo(name)
    info.type = kind
    info.linkname = "/etc/passwd"
    return info, content if kind == tarfile.REGTYPE else b""


GOOD = archive(
    member("./", kind=tarfile.DIRTYPE), member("./apm"), member("./sub/default_eeprom.bin", b"stored")
)


def gives(data: bytes, *, promised: int | None = None, status: int = 200) -> Answer:
    """An answer with these bytes, which may announce more than it sends."""

    def answer(handler: http.server.BaseHTTPRequestHandler) -> None:
        handler.send_response(status)
        handler.send_header("Content-Length", str(len(data) if promised is None else promised))
        handler.end_headers()
        handler.wfile.write(data)

    return answer


def source(web: StandIn, tmp_path: Path) -> DownloadSource:
    return DownloadSource(web.url, tmp_path / "cache", "linux")


def test_a_download_is_complete_in_the_cache(web: StandIn, tmp_path: Path) -> None:
    """From the address that dronekit-sitl uses, unpacked, executable, with progress events."""
    web.answer = gives(GOOD)
    told: list[Event] = []
    place = source(web, tmp_path)
    assert place.cached() is None
    binary = download(place, told.append)
    assert binary == tmp_path / "cache" / "copter-3.3" / "apm" == place.cached()
    assert binary.read_bytes() == b"binary"
    assert binary.stat().st_mode & 0o111
    assert (binary.parent / "sub" / "default_eeprom.bin").read_bytes() == b"stored"
    assert web.asked == ["/sitl/copter/sitl-linux-copter-3.3.tar.gz"]
    assert Progress("ArduPilot SITL", len(GOOD), len(GOOD), "bytes") in told
    assert [path.name for path in place.cache.iterdir()] == ["copter-3.3"]


BAD: dict[str, tuple[Answer, str]] = {
    "not found": (gives(b"", status=404), "404"),
    "cut short": (gives(GOOD[:100], promised=len(GOOD)), "cannot download"),
    "no archive": (gives(b"<html>captive portal</html>"), "cannot download"),
    "half an archive": (gives(GOOD[:60]), "cannot download"),
    "no simulator": (gives(archive(member("readme"))), "contains no simulator"),
    "climbs out": (gives(archive(member("../../evil"))), "outside its folder"),
    "absolute": (gives(archive(member("/tmp/evil"))), "outside its folder"),
    "drive": (gives(archive(member("C:/evil"))), "outside its folder"),
    "backslashes": (gives(archive(member("..\\evil"))), "outside its folder"),
    "symbolic link": (gives(archive(member("apm", kind=tarfile.SYMTYPE))), "neither file nor folder"),
    "hard link": (gives(archive(member("apm", kind=tarfile.LNKTYPE))), "neither file nor folder"),
    "device": (gives(archive(member("apm", kind=tarfile.CHRTYPE))), "neither file nor folder"),
}


@pytest.mark.parametrize(("answer", "words"), BAD.values(), ids=BAD.keys())
def test_a_bad_download_leaves_nothing(web: StandIn, tmp_path: Path, answer: Answer, words: str) -> None:
    """No part of it remains in or outside the cache, and the error names the cause."""
    web.answer = answer
    place = source(web, tmp_path)
    with pytest.raises(SimulatorError, match=words):
        download(place)
    assert list(place.cache.iterdir()) == []
    assert {path.name for path in tmp_path.iterdir()} == {"cache"}


def test_a_silent_server_has_a_time_limit(web: StandIn, tmp_path: Path) -> None:
    """The connection is closed."""
    over = threading.Event()
    web.answer = lambda handler: [over.wait(60)]
    with pytest.raises(SimulatorError, match="timed out"):
        download(source(web, tmp_path), silence_s=0.3)
    over.set()


def test_a_slow_download_ends_at_its_time_limit(web: StandIn, tmp_path: Path) -> None:
    """However slowly bytes arrive."""

    def trickle(handler: http.server.BaseHTTPRequestHandler) -> None:
        handler.send_response(200)
        handler.end_headers()
        try:
            for _ in range(100):
                handler.wfile.write(b"x" * (1 << 16))
                time.sleep(0.05)
        except OSError:
            return

    web.answer = trickle
    with pytest.raises(SimulatorError, match="the download takes too long"):
        download(source(web, tmp_path), limit_s=0.3)


def test_a_download_without_end_has_a_size_limit(
    web: StandIn, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """More bytes than any simulator has are not stored."""
    monkeypatch.setattr(fetch, "_LARGEST_BYTES", 1000)
    web.answer = raw(b"HTTP/1.0 200 OK\r\n\r\n" + b"x" * 5000)
    with pytest.raises(SimulatorError, match="too large"):
        download(source(web, tmp_path))


def test_a_size_that_is_announced_is_refused_before_it_is_read(web: StandIn, tmp_path: Path) -> None:
    """More than any simulator has."""
    web.answer = gives(b"", promised=1 << 40)
    with pytest.raises(SimulatorError, match="too large"):
        download(source(web, tmp_path))


def gzipped(*pieces: tuple[bytes, int]) -> bytes:
    """A gzip file of pieces, each so many times, in as many members: each is compressed once."""
    return b"".join(gzip.compress(piece) * times for piece, times in pieces)


def header(name: str, size: int, kind: bytes = tarfile.REGTYPE) -> bytes:
    """A header of a tar file that announces ``size`` bytes."""
    info = tarfile.TarInfo(name)
    info.size, info.type = size, kind
    return info.tobuf(tarfile.GNU_FORMAT)


def sparse(size: int) -> bytes:
    """An archive of some bytes whose one member is a hole."""
    info = tarfile.TarInfo("apm")
    info.type = tarfile.GNUTYPE_SPARSE
    block = bytearray(info.tobuf(tarfile.GNU_FORMAT))
    block[386:398] = block[398:410] = b"%011o " % 0
    block[483:495] = b"%011o " % size
    block[148:156] = b" " * 8
    block[148:156] = b"%06o\0 " % sum(block)
    return gzip.compress(bytes(block) + b"\0" * 1024)


_MB = b"\0" * (1 << 20)
BOMBS = {
    "a file": gzipped((header("apm", 3 << 30), 1), (_MB, 3 << 10)),
    "a hole": sparse(1 << 33),
    "a long name": gzipped((header("././@LongLink", 200 << 20, tarfile.GNUTYPE_LONGNAME), 1), (_MB, 200)),
    "a pax header": gzipped((header("x", 200 << 20, tarfile.XHDTYPE), 1), (_MB, 200)),
    "many files": gzipped((header("x", 0), 1500)),
}
MEASURED = """
import resource, sys
from pathlib import Path
from flight_replay.exceptions import SimulatorError
from flight_replay.vehicle.sitl.download import DownloadSource, download
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
try:
    download(DownloadSource(sys.argv[1], Path(sys.argv[2]), "linux"))
except SimulatorError as error:
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before, error)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no resource module")
@pytest.mark.parametrize("bomb", BOMBS.values(), ids=BOMBS.keys())
def test_a_small_archive_that_expands_is_refused(web: StandIn, tmp_path: Path, bomb: bytes) -> None:
    """It takes neither the disk nor the memory."""
    assert len(bomb) < 4 << 20
    web.answer = gives(bomb)
    command = [sys.executable, "-c", MEASURED, web.url, str(tmp_path / "cache")]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
    kilobytes, error = done.stdout.split(" ", 1)
    assert "too large" in error
    assert int(kilobytes) < 50_000
    assert list((tmp_path / "cache").iterdir()) == []


def test_an_archive_that_expands_takes_no_more_of_the_disk_than_is_allowed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is refused while it is unpacked, not afterwards."""
    monkeypatch.setattr(unpack, "_LARGEST_BYTES", 5 << 20)
    (tmp_path / "sitl.tar.gz").write_bytes(gzipped((header("apm", 100 << 20), 1), (_MB, 100)))
    with pytest.raises(tarfile.TarError, match="too large"):
        unpack.unpack(tmp_path / "sitl.tar.gz", tmp_path / "unpacked")
    sizes = [path.stat().st_size for path in tmp_path.rglob("*") if path.is_file()]
    assert sum(sizes) <= 6 << 20


@pytest.mark.parametrize("pinned", [hashlib.sha256(GOOD).hexdigest().upper(), None], ids=["known", "unknown"])
def test_a_known_sha256_is_checked_and_an_unknown_one_told(
    web: StandIn, tmp_path: Path, pinned: str | None
) -> None:
    """Whoever downloads it can compare it with that of others."""
    web.answer = gives(GOOD)
    place = source(web, tmp_path)
    told: list[Event] = []
    download(replace(place, sha256=pinned), told.append)
    notices = [event.text for event in told if isinstance(event, Notice)]
    assert notices[0].endswith(f"from {place.url}")
    assert any(hashlib.sha256(GOOD).hexdigest() in text for text in notices) is (pinned is None)


def test_an_archive_with_another_sha256_is_refused(web: StandIn, tmp_path: Path) -> None:
    """Nothing of it is unpacked."""
    web.answer = gives(GOOD)
    place = replace(source(web, tmp_path), sha256="0" * 64)
    with pytest.raises(SimulatorError, match="it is another file"):
        download(place)
    assert list(place.cache.iterdir()) == []


@pytest.mark.parametrize("target", ["http://127.0.0.1:{port}/x", "ftp://127.0.0.1/x", "file:///etc/passwd"])
def test_a_redirect_to_anything_but_https_is_refused(web: StandIn, tmp_path: Path, target: str) -> None:
    """Who can change an answer on its way could name any file."""
    web.answer = redirects(target.format(port=web.server.server_port))
    with pytest.raises(SimulatorError, match=r"which is not https|not allowed"):
        download(source(web, tmp_path))
    assert len(web.asked) == 1


def test_a_redirect_to_https_is_followed(web: StandIn, tmp_path: Path) -> None:
    """The stand-in does not speak TLS, which is the error then."""
    web.answer = redirects(f"https://127.0.0.1:{web.server.server_port}/x")
    with pytest.raises(SimulatorError, match="SSL"):
        download(source(web, tmp_path))


def redirects(target: str) -> Answer:
    """An answer that sends the program elsewhere."""

    def answer(handler: http.server.BaseHTTPRequestHandler) -> None:
        handler.send_response(302)
        handler.send_header("Location", target)
        handler.send_header("Content-Length", "0")
        handler.end_headers()

    return answer


@pytest.mark.parametrize("line", [b"HTTP/1.0 200 OK", b"HTTP/1.0 200 OK\r\nX: "], ids=["status", "header"])
def test_headers_that_drip_have_a_time_limit(web: StandIn, tmp_path: Path, line: bytes) -> None:
    """Each byte resets a socket's timeout, but not the limit of the download."""
    over = threading.Event()

    def drips(handler: http.server.BaseHTTPRequestHandler) -> None:
        handler.wfile.write(line)
        while not over.wait(0.05):
            try:
                handler.wfile.write(b"x")
            except OSError:
                return

    web.answer = drips
    began_s = time.monotonic()
    with pytest.raises(SimulatorError, match="the download takes too long"):
        download(source(web, tmp_path), limit_s=0.5)
    assert time.monotonic() - began_s < 5
    over.set()


@pytest.mark.skipif(not hasattr(tarfile, "data_filter"), reason="early versions of 3.10 have none")
def test_pythons_own_filter_is_asked_about_each_member(
    web: StandIn, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It may know of a danger that this program does not."""
    asked: list[str] = []

    def refuse(member: tarfile.TarInfo, folder: str) -> tarfile.TarInfo:
        asked.append(member.name)
        if member.name.endswith("eeprom.bin"):
            raise tarfile.OutsideDestinationError(member, folder)
        return member

    monkeypatch.setattr(tarfile, "data_filter", refuse)
    web.answer = gives(GOOD)
    place = source(web, tmp_path)
    with pytest.raises(SimulatorError, match=r"eeprom\.bin"):
        download(place)
    assert len(asked) == 3
    assert list(place.cache.iterdir()) == []


def test_python_without_a_filter_unpacks_as_safely(
    web: StandIn, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Early versions of 3.10 have none."""
    monkeypatch.delattr(tarfile, "data_filter", raising=False)
    web.answer = gives(archive(member("../../evil")))
    with pytest.raises(SimulatorError, match="outside its folder"):
        download(source(web, tmp_path))
    web.answer = gives(GOOD)
    assert download(source(web, tmp_path)).is_file()


def test_a_cache_that_cannot_be_written_is_an_error(web: StandIn, tmp_path: Path) -> None:
    """A file in place of the folder, for example."""
    (tmp_path / "cache").write_text("in the way")
    with pytest.raises(SimulatorError, match="cannot download"):
        download(source(web, tmp_path))


def test_dronekit_sitls_addresses_are_used_over_https(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its host and its cache, but not its plain http."""
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(platform, "machine", lambda: "x86_64")
    found = dronekit_sitl_source()
    assert found.url == "https://dronekit-assets.s3.amazonaws.com/sitl/copter/sitl-linux-copter-3.3.tar.gz"
    assert found.cache == Path.home() / ".dronekit" / "sitl"


@pytest.mark.skipif(sys.version_info >= (3, 14), reason="dronekit-sitl cannot be imported on Python 3.14")
def test_the_addresses_are_those_of_dronekit_sitl() -> None:
    """The package says the same."""
    import dronekit_sitl

    found = dronekit_sitl_source()
    assert found.base_url == dronekit_sitl.sitl_host.replace("http://", "https://")
    assert found.cache == Path(dronekit_sitl.sitl_target)


def test_a_user_without_a_home_folder_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """A container may run as a number without a name."""
    pwd = pytest.importorskip("pwd")

    def nobody(uid: int) -> None:
        raise KeyError(uid)

    monkeypatch.delenv("HOME", raising=False)
    monkeypatch.setattr(pwd, "getpwuid", nobody)
    with pytest.raises(SimulatorError, match="set HOME, or name a binary with --sitl"):
        dronekit_sitl_source()


def test_machines_without_binaries_are_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """dronekit-sitl has none for ARM."""
    monkeypatch.setattr(platform, "machine", lambda: "aarch64")
    with pytest.raises(SimulatorError, match=r"no binary for .* on aarch64"):
        dronekit_sitl_source()


def test_an_unknown_host_name_is_an_error(tmp_path: Path) -> None:
    """Without a network, for example."""
    place = DownloadSource("https://no-such-host.invalid/sitl", tmp_path / "cache", "linux")
    with pytest.raises(SimulatorError, match=r"unknown host name no-such-host\.invalid"):
        download(place)


def test_a_silent_name_server_has_a_time_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As the download has."""
    over = threading.Event()
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: [over.wait(10)])
    place = DownloadSource("https://slow.invalid/sitl", tmp_path / "cache", "linux")
    with pytest.raises(SimulatorError, match="no answer for host name"):
        download(place, silence_s=0.2)
    over.set()


def test_a_proxy_looks_up_names_itself(web: StandIn, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Behind a proxy the name need not resolve on this machine."""
    monkeypatch.setenv("http_proxy", web.url.removesuffix("/sitl"))
    web.answer = gives(GOOD)
    place = DownloadSource("http://no-such-host.invalid/sitl", tmp_path / "cache", "linux")
    assert download(place).is_file()


def raw(data: bytes) -> Answer:
    """An answer byte for byte, whatever HTTP says."""

    def answer(handler: http.server.BaseHTTPRequestHandler) -> None:
        handler.wfile.write(data)

    return answer


def corrupted(data: bytes) -> bytes:
    """An archive with some bytes in its middle changed."""
    return data[: len(data) // 2] + b"corrupted" + data[len(data) // 2 + 6 :]


NONSENSE = {
    "a page": gives(b"<html>log in first</html>"),
    "no length": raw(b"HTTP/1.0 200 OK\r\nContent-Length: many\r\n\r\n"),
    "no HTTP": raw(b"220 mail.example.org\r\nESMTP\r\n"),
    "torn pieces": raw(b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n40\r\nabc"),
    "corrupted": gives(corrupted(archive(member("apm", random.Random(1).randbytes(100_000))))),
}


@pytest.mark.parametrize("answer", NONSENSE.values(), ids=NONSENSE.keys())
def test_any_faulty_answer_is_one_line(answer: Answer, web: StandIn, tmp_path: Path) -> None:
    """Whatever is wrong with a server or an archive is an expected error, and leaves nothing behind."""
    web.answer = answer
    place = source(web, tmp_path)
    with pytest.raises(SimulatorError, match="cannot download ArduPilot SITL") as told:
        download(place)
    assert "\n" not in str(told.value)
    assert list(place.cache.iterdir()) == []


def test_a_download_of_single_bytes_has_a_time_limit(web: StandIn, tmp_path: Path) -> None:
    """A byte now and then is neither silence nor progress."""
    over = threading.Event()

    def drips(handler: http.server.BaseHTTPRequestHandler) -> None:
        handler.send_response(200)
        handler.end_headers()
        for _ in range(1200):
            if over.wait(0.05):
                return
            handler.wfile.write(b"x")

    web.answer = drips
    with pytest.raises(SimulatorError, match="the download takes too long"):
        download(source(web, tmp_path), limit_s=0.5)
    over.set()


def test_a_broken_download_of_dronekit_sitl_is_replaced(web: StandIn, tmp_path: Path) -> None:
    """A folder without a simulator."""
    web.answer = gives(GOOD)
    place = source(web, tmp_path)
    place.folder.mkdir(parents=True)
    (place.folder / "sitl.tar.gz").write_bytes(b"torn")
    assert download(place) == place.cached()
    assert not (place.folder / "sitl.tar.gz").exists()


def test_another_run_may_be_faster(web: StandIn, tmp_path: Path) -> None:
    """Of two downloads at once the first is kept, and both runs have a simulator."""
    place = source(web, tmp_path)

    def answer(handler: http.server.BaseHTTPRequestHandler) -> None:
        place.folder.mkdir(parents=True)
        (place.folder / "apm").write_bytes(b"the other's")
        gives(GOOD)(handler)

    web.answer = answer
    assert download(place).read_bytes() == b"the other's"
