"""A serial cable to a TCP simulator: a pseudo-terminal behind a stable device name, that can be unplugged."""

from __future__ import annotations

import os
import select
import socket
import threading
import tty
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


class SerialCable:
    """Carries bytes between the device ``path`` and a TCP connection while it is plugged in."""

    def __init__(self, path: Path, connection: str) -> None:
        host, _, port = connection.removeprefix("tcp:").rpartition(":")
        self.path = path
        self._socket = socket.create_connection((host, int(port)))
        self._lock = threading.Lock()
        self._master: int | None = None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._carry, daemon=True)
        self.plug_in()
        self._thread.start()

    def plug_in(self) -> None:
        """The device appears."""
        master, slave = os.openpty()
        tty.setraw(slave)
        self.path.symlink_to(os.ttyname(slave))
        os.set_blocking(master, False)
        with self._lock:
            self._master, self._slave = master, slave

    def unplug(self) -> None:
        """The device is gone, as when a USB cable is pulled."""
        with self._lock:
            master, self._master = self._master, None
            self.path.unlink()
            os.close(self._slave)
            if master is not None:
                os.close(master)

    def _carry(self) -> None:
        while not self._stop.is_set():
            with self._lock, suppress(OSError):
                ends: list[socket.socket | int] = [
                    self._socket,
                    *([] if self._master is None else [self._master]),
                ]
                for end in select.select(ends, [], [], 0.005)[0]:
                    self._pass_on(end)
            self._stop.wait(0.001)

    def _pass_on(self, end: socket.socket | int) -> None:
        if isinstance(end, int):
            self._socket.sendall(os.read(end, 4096))
            return
        data = end.recv(4096)
        if self._master is not None:
            os.write(self._master, data)

    def close(self) -> None:
        self._stop.set()
        self._thread.join(5)
        if self._master is not None:
            self.unplug()
        self._socket.close()


@contextmanager
def serial_cable(path: Path, connection: str) -> Iterator[SerialCable]:
    """A plugged-in cable for the length of the block."""
    cable = SerialCable(path, connection)
    try:
        yield cable
    finally:
        cable.close()
