"""Connection strings: the transport that one names, opened for the first time."""

from __future__ import annotations

import os
import socket
import time

from flight_replay.errors import VehicleError
from flight_replay.vehicle.link.transport import Serial, TcpClient, Transport, UdpClient, UdpListener

_RETRY_S = 5.0  # A simulator that was just started may not listen yet.
_PAUSE_S = 0.2


def open_transport(connection_string: str, baud: int) -> Transport:
    """The open transport of a connection string.

    Raises:
        VehicleError: The string is invalid, or the connection cannot be opened.
    """
    transport = transport_for(connection_string, baud)
    end_s = time.monotonic() + _RETRY_S
    while True:
        try:
            transport.open()
            return transport
        except ConnectionRefusedError as error:
            if time.monotonic() > end_s:
                raise VehicleError(
                    f"connection to {connection_string} refused: nothing listens there; "
                    "start the vehicle or simulator first"
                ) from error
            time.sleep(_PAUSE_S)
        except socket.gaierror as error:
            raise VehicleError(
                f"cannot resolve the host of {connection_string}: {error.strerror}; check the host name"
            ) from error
        except OSError as error:
            transport.close()
            raise VehicleError(
                f"cannot open {connection_string}: {os.strerror(error.errno) if error.errno else error}; "
                "check that it exists and that no other program uses it"
            ) from error


def transport_for(connection_string: str, baud: int) -> Transport:
    """The transport that a connection string names.

    Raises:
        VehicleError: The string is invalid.
    """
    kind, _, rest = connection_string.partition(":")
    kind = kind.lower()
    if kind == "tcp":
        return TcpClient(_address(connection_string, rest))
    if kind == "udpout":
        return UdpClient(_address(connection_string, rest))
    if kind in ("udp", "udpin"):
        return UdpListener(_address(connection_string, rest))
    if rest.isascii() and rest.isdecimal() and "/" not in kind:
        return UdpListener(_address(connection_string, connection_string))
    device, _, speed = connection_string.partition(",")
    if not device:
        raise _invalid(connection_string)
    return Serial(device, int(speed) if speed.isascii() and speed.isdecimal() else baud)


def _address(connection_string: str, host_port: str) -> tuple[str, int]:
    host, _, port = host_port.rpartition(":")
    if not (port.isascii() and port.isdecimal()) or not 0 < int(port) < 65536:
        raise _invalid(connection_string)
    return host.strip("[]") or "0.0.0.0", int(port)


def _invalid(connection_string: str) -> VehicleError:
    return VehicleError(
        f"invalid connection string {connection_string!r}; "
        "write tcp:HOST:PORT, udp:HOST:PORT, udpout:HOST:PORT or a serial port"
    )
