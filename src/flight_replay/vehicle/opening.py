"""Opens a connection for the first time, in which failures are told; later ones are mended in silence."""

from __future__ import annotations

import os
import socket
import time

from flight_replay.errors import VehicleError
from flight_replay.vehicle.transport import Transport, transport_for

_RETRY_S = 5.0  # A simulator that was just started may not listen yet.
_PAUSE_S = 0.2


def opened(connection_string: str, baud: int) -> Transport:
    """The open transport of a connection string.

    Raises:
        VehicleError: The string cannot be understood, or the connection not be opened.
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
                    f"nothing listens on {connection_string}; start the vehicle or simulator first"
                ) from error
            time.sleep(_PAUSE_S)
        except socket.gaierror as error:
            raise VehicleError(
                f"cannot find the host of {connection_string}: {error.strerror}; check its name"
            ) from error
        except OSError as error:
            transport.close()
            raise VehicleError(
                f"cannot open {connection_string}: {os.strerror(error.errno) if error.errno else error}; "
                "check that it exists and that no other program uses it"
            ) from error
