"""The bytes of a log where it is read: from a path that this machine sees, or as they were sent."""

from __future__ import annotations

import hashlib
import io
import os
from dataclasses import dataclass
from pathlib import Path

from flight_replay.cli.many.log_files import LogFile
from flight_replay.exceptions import FlightReplayError
from flight_replay.logs.byte_source import OpenLog
from flight_replay.logs.read_log import read_log, read_open_log
from flight_replay.logs.recording import Recording
from flight_replay.logs.vehicles import VehicleId

_PIECE = 1 << 20
MOST_SENT_BYTES = 16 << 20
"""Logs up to this size are sent to workers that do not see their path."""


@dataclass(frozen=True, slots=True)
class LogContent:
    """A log, and its bytes where they were sent."""

    file: LogFile
    sent: bytes | None = None

    @property
    def is_out_of_sight(self) -> bool:
        """Whether it is not here, though it was where the run was started."""
        return self.sent is None and self.file.bytes is not None and not os.path.exists(self.file.path)  # noqa: PTH110

    def sha256(self) -> str:
        """The hash of the stored bytes.

        Raises:
            FlightReplayError: It cannot be read.
        """
        if self.sent is not None:
            return hashlib.sha256(self.sent).hexdigest()
        return file_sha256(Path(self.file.path))

    def read(self, vehicle: VehicleId | None) -> Recording:
        """The recording of a vehicle.

        Raises:
            LogError: There is nothing usable in it.
        """
        if self.sent is None:
            return read_log(self.file.path, vehicle=vehicle)
        return read_open_log(OpenLog(self.file.path, io.BytesIO(self.sent), len(self.sent)), vehicle=vehicle)


def file_sha256(path: Path) -> str:
    """The hash of a file.

    Raises:
        FlightReplayError: It cannot be read.
    """
    digest = hashlib.sha256()
    try:
        with path.open("rb", buffering=0) as file:
            while piece := file.read(_PIECE):
                digest.update(piece)
    except FileNotFoundError:
        raise FlightReplayError(f"{path} does not exist; check its path") from None
    except OSError as error:
        raise FlightReplayError(f"{path} cannot be read ({error.strerror}); check its rights") from error
    return digest.hexdigest()
