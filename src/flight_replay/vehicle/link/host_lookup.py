"""Resolves a host name within a time limit, which sockets do not have and during which Ctrl-C works."""

from __future__ import annotations

import socket
import threading
from typing import Any

AddressInfo = tuple[socket.AddressFamily, socket.SocketKind, int, str, Any]
"""Family, kind, protocol, canonical name and address, as from ``socket.getaddrinfo``."""


def look_up(
    host: str, port: int | str, limit_s: float, kind: socket.SocketKind = socket.SOCK_STREAM
) -> list[AddressInfo]:
    """The addresses of a host, at least one.

    Raises:
        socket.gaierror: The name is unknown or invalid.
        TimeoutError: No name server answers in time.
    """
    found: list[AddressInfo] = []
    failures: list[OSError] = []

    def resolve() -> None:
        try:
            found.extend(socket.getaddrinfo(host, port, type=kind))
        except OSError as error:
            failures.append(error)
        except UnicodeError:
            failures.append(socket.gaierror(socket.EAI_NONAME, "invalid host name"))

    thread = threading.Thread(target=resolve, daemon=True)
    thread.start()
    thread.join(limit_s)
    if thread.is_alive():
        raise TimeoutError(f"no answer for host name {host} in {limit_s:g} s")
    if failures:
        raise failures[0]
    return found
