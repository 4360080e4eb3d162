"""Runs an ArduCopter SITL binary in a temporary folder, and removes both in the end."""

from __future__ import annotations

import contextlib
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from flight_replay.events import Listener, Notice, ignore
from flight_replay.exceptions import SimulatorError
from flight_replay.simulator.autopilot.location import Start
from flight_replay.vehicle.sitl.bench_parameters import bench_text
from flight_replay.vehicle.sitl.locate import SitlBinary
from flight_replay.vehicle.sitl.watched_folder import WatchedFolder

_HELP_S = 10.0
_READY_S = 30.0
_STOP_S = 3.0
_POLL_S = 0.02
_READY = "Waiting for connection"
_BASE_PORT = 5760
_PORTS_PER_INSTANCE = 10
_SERIAL_PORTS = (0, 2, 3)  # SERIAL0 to SERIAL2 listen here, from the instance's first port.
_INSTANCES = 200
_SHOWN_LINES = 3
_STARTS = 20  # So many simulators that start at once each find free ports.


@dataclass(frozen=True, slots=True)
class SitlProcess:
    """A simulator that was started; ``log`` is its output."""

    path: Path
    port: int
    process: subprocess.Popen[bytes]
    log: Path

    @property
    def connection(self) -> str:
        """Its connection string."""
        return f"tcp:127.0.0.1:{self.port}"

    @property
    def ended(self) -> SimulatorError | None:
        """That it ended, with its last output; None while it runs."""
        status = self.process.poll()
        if status is None:
            return None
        return SimulatorError(
            f"{self.path} ended with status {status}; its last output: {self.last_output or 'nothing'}"
        )

    @property
    def last_output(self) -> str:
        """The last lines of its output, on one line."""
        return _last_lines(self.log.read_text(errors="replace"))


@contextlib.contextmanager
def run(
    binary: SitlBinary, start: Start, *, speedup: float = 1.0, listener: Listener = ignore
) -> Iterator[SitlProcess]:
    """Run ``binary`` for as long as the context lasts, with a copter at ``start``.

    A flight that was measured is none to lose: if the binary ended in it, ``listener`` is told.

    Raises:
        SimulatorError: It does not start, or ended and the context with an error; with its last output.
    """
    options = _options(binary.path)
    with WatchedFolder() as folder:
        _prepare(binary, options, folder, start)
        with _started(_command(binary, options, folder, start, speedup), folder) as running:
            yield running
            if why := running.ended:
                listener(Notice(f"the simulator ended before the flight did: {why}", warning=True))


def _options(path: Path) -> str:
    """The output of ``--help``, to know the options of the binary."""
    try:
        shown = subprocess.run(
            [path, "--help"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=_HELP_S,
            check=False,
        )
    except OSError as error:
        raise SimulatorError(
            f"cannot run {path}: {error.strerror}; is it a binary for this machine?"
        ) from error
    except subprocess.TimeoutExpired as error:
        raise SimulatorError(f"{path} does not end after --help; is it an ArduCopter SITL binary?") from error
    text = shown.stdout.decode(errors="replace")
    if "--home" not in text or "--model" not in text:
        raise SimulatorError(
            f"{path} is not an ArduCopter SITL binary of 3.3 or later; its output: {_last_lines(text)}"
        )
    return text


def _prepare(binary: SitlBinary, options: str, folder: WatchedFolder, start: Start) -> None:
    """Provide the parameters: as a file, or in the EEPROM of a binary that takes no such file."""
    if "--defaults" in options:
        (folder.path / "bench.parm").write_text(bench_text())
        return
    stored = binary.path.parent / "default_eeprom.bin"
    if stored.is_file():
        shutil.copy(stored, folder.path / "eeprom.bin")
        return
    from flight_replay.vehicle.sitl.eeprom import store_bench_parameters

    with _started(_command(binary, options, folder, start, 1.0), folder) as running:
        store_bench_parameters(running.connection, binary.defaults)


@contextlib.contextmanager
def _started(command: Sequence[Path | str], folder: WatchedFolder) -> Iterator[SitlProcess]:
    """Run the simulator; if it ended, an error in the context becomes an error of the simulator."""
    running = _ready(command, folder)
    try:
        yield running
    except SimulatorError:
        raise
    except Exception as error:
        if why := running.ended:
            raise why from error
        raise
    finally:
        _stop(running.process, folder)


def _ready(command: Sequence[Path | str], folder: WatchedFolder) -> SitlProcess:
    """A simulator that waits for a connection.

    It is started again if another simulator took its ports first.
    """
    log = folder.path / "console.txt"
    for tries_left in reversed(range(_STARTS)):
        instance = _free_instance()
        process = folder.spawn([*command, f"-I{instance}"], log)
        running = SitlProcess(Path(command[0]), _first_port(instance), process, log)
        try:
            _wait_ready(running)
            return running
        except BaseException as error:
            ports_taken = process.poll() is not None and not _is_free_instance(instance)
            _stop(process, folder)
            if not (isinstance(error, SimulatorError) and ports_taken and tries_left):
                raise
    raise AssertionError("the last start returns or raises")


def _command(
    binary: SitlBinary, options: str, folder: WatchedFolder, start: Start, speedup: float
) -> list[Path | str]:
    command: list[Path | str] = [
        binary.path, "--model", "+",
        f"--home={start.lat_deg:.8f},{start.lon_deg:.8f},{start.alt_amsl_m:.3f},{start.heading_deg:.2f}",
    ]  # fmt: skip
    if "--defaults" in options:
        files = [path.absolute() for path in binary.defaults] or [folder.path / "bench.parm"]
        command += ["--defaults", ",".join(map(str, files))]
    if "--speedup" in options:
        command += ["--speedup", f"{speedup:g}"]
    return command


def _free_instance() -> int:
    """The lowest instance whose ports are free: other simulators may be running."""
    for instance in range(_INSTANCES):
        if _is_free_instance(instance):
            return instance
    raise SimulatorError(f"all SITL ports from {_BASE_PORT} on are in use; stop other simulators")


def _first_port(instance: int) -> int:
    return _BASE_PORT + _PORTS_PER_INSTANCE * instance


def _is_free_instance(instance: int) -> bool:
    return all(_is_free_port(_first_port(instance) + offset) for offset in _SERIAL_PORTS)


def _is_free_port(port: int) -> bool:
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("0.0.0.0", port))
        except OSError:
            return False
    return True


def _wait_ready(running: SitlProcess) -> None:
    end_s = time.monotonic() + _READY_S
    while _READY not in running.log.read_text(errors="replace"):
        if why := running.ended:
            raise why
        if time.monotonic() > end_s:
            raise SimulatorError(
                f"{running.path} does not wait for a connection after {_READY_S:.0f} s; "
                f"its last output: {running.last_output}"
            )
        time.sleep(_POLL_S)


def _last_lines(text: str) -> str:
    """The last lines of a text, on one line."""
    lines: Sequence[str] = [line.strip() for line in text.splitlines() if line.strip()]
    return " / ".join(lines[-_SHOWN_LINES:])


def _stop(process: subprocess.Popen[bytes], folder: WatchedFolder) -> None:
    """Terminate the process; kill it if it does not end."""
    process.terminate()
    try:
        process.wait(_STOP_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    folder.forget(process)
