"""Finds a host's address in time: no time limit of a socket holds for that, and Ctrl-C neither."""

from __future__ import annotations

import socket
import threading
from typing import Any

AddressInfo = tuple[socket.AddressFamily, socket.SocketKind, int, str, Any]
"""Family, kind, protocol, canonical name and address, as of ``socket.getaddrinfo``."""


def look_up(
    host: str, port: int | str, limit_s: float, kind: socket.SocketKind = socket.SOCK_STREAM
) -> list[AddressInfo]:
    """A name's addresses, at least one.

    Raises:
        socket.gaierror: The name is not known, or is none.
        TimeoutError: Nobody answers in time.
    """
    found: list[AddressInfo] = []
    failures: list[OSError] = []

    def ask() -> None:
        try:
            found.extend(socket.getaddrinfo(host, port, type=kind))
        except OSError as error:
            failures.append(error)
        except UnicodeError:
            failures.append(socket.gaierror(socket.EAI_NONAME, "no host is named like that"))

    thread = threading.Thread(target=ask, daemon=True)
    thread.start()
    thread.join(limit_s)
    if thread.is_alive():
        raise TimeoutError(f"the name {host} is not found in time")
    if failures:
        raise failures[0]
    return found
