"""Connection strings: the transport that one names, opened for the first time."""

from __future__ import annotations

import errno
import os
import socket
import time

from flight_replay.exceptions import VehicleError
from flight_replay.simulator.server.addresses import KINDS, is_serial_port, parse_network_address
from flight_replay.vehicle.link.transport import Serial, TcpClient, Transport, UdpClient, UdpListener

_RETRY_S = 5.0  # A simulator that was just started may not listen yet.
_PAUSE_S = 0.2
_NEXT_STEPS = {
    errno.EACCES: "let your user use it (on Linux: its group, such as dialout, then log in again)",
    errno.EADDRNOTAVAIL: "udp: listens, at addresses of this computer; udpout:HOST:PORT sends to a vehicle",
    errno.EADDRINUSE: "another program listens there: end it, or let the vehicle send to another port",
}
"""What to do about some errors."""


def open_transport(connection_string: str, baud: int, *, keeps_trying: bool = False) -> Transport:
    """The open transport of a connection string.

    Args:
        connection_string: As for DroneKit: see ``transport``.
        baud: Baud rate of a serial port.
        keeps_trying: Try again as long as it takes, whatever keeps it from being opened.

    Raises:
        VehicleError: The string is invalid, or the connection cannot be opened.
    """
    transport = transport_for(connection_string, baud)
    end_s = time.monotonic() + _RETRY_S
    while True:
        try:
            transport.open()
            return transport
        except OSError as error:
            transport.close()
            is_refused = isinstance(error, ConnectionRefusedError)
            if not keeps_trying and not (is_refused and time.monotonic() <= end_s):
                raise _cannot_open(connection_string, error) from error
            time.sleep(_PAUSE_S)


def _cannot_open(connection_string: str, error: OSError) -> VehicleError:
    """What keeps a connection from being opened, and what to do."""
    if isinstance(error, ConnectionRefusedError):
        return VehicleError(
            f"connection to {connection_string} refused: nothing listens there; "
            "start the vehicle or simulator first (flight-replay waits for it with --wait)"
        )
    if isinstance(error, socket.gaierror):
        return VehicleError(
            f"cannot resolve the host of {connection_string}: {error.strerror}; check the host name"
        )
    next_step = _NEXT_STEPS.get(error.errno or 0, "check that it exists and that no other program uses it")
    what = os.strerror(error.errno) if error.errno else error
    return VehicleError(f"cannot open {connection_string}: {what}; {next_step}")


def silence_hint(connection_string: str, baud: int) -> str:
    """What to check on a connection that is open, where no vehicle is heard."""
    transport = transport_for(connection_string, baud)
    if isinstance(transport, UdpListener):
        return (
            "check that the vehicle's telemetry is sent to this address (MAVProxy: --out=udpout:HOST:PORT), "
            "and that no firewall or other program takes it"
        )
    if isinstance(transport, Serial):
        return f"check the port, the baud rate (--baud, now {transport.baud}), and the vehicle's power"
    return "check that this is the address of a vehicle, and that it is switched on"


def transport_for(connection_string: str, baud: int) -> Transport:
    """The transport that a connection string names.

    Raises:
        VehicleError: The string is invalid.
    """
    if is_serial_port(connection_string):
        device, _, speed = connection_string.partition(",")
        if not device:
            raise _invalid(connection_string)
        return Serial(device, int(speed) if speed.isascii() and speed.isdecimal() else baud)
    has_kind = connection_string.partition(":")[0].lower() in KINDS
    address = parse_network_address(connection_string if has_kind else f"udpin:{connection_string}")
    if address is None or address.port == 0 or address.kind not in _TRANSPORTS:
        raise _invalid(connection_string)
    return _TRANSPORTS[address.kind]((address.host or _ANY_HOST, address.port))


_ANY_HOST = "0.0.0.0"
_TRANSPORTS: dict[str, type[TcpClient] | type[UdpClient] | type[UdpListener]] = {
    "tcp": TcpClient,
    "udpout": UdpClient,
    "udpin": UdpListener,
}


def _invalid(connection_string: str) -> VehicleError:
    return VehicleError(
        f"invalid connection string {connection_string!r}; "
        "write tcp:HOST:PORT, udpin:HOST:PORT, udpout:HOST:PORT or a serial port"
    )
