"""Reads a DataFlash log as ArduPilot writes it on board (``.bin``)."""

from __future__ import annotations

import numpy as np

from flight_replay.exceptions import LogError
from flight_replay.logs.byte_source import OpenLog, Progress
from flight_replay.logs.dataflash.collected import MESSAGES, Collected
from flight_replay.logs.dataflash.dataflash_recording import LogContents, dataflash_recording
from flight_replay.logs.dataflash.record_stream import RecordStream
from flight_replay.logs.recording import Recording
from flight_replay.logs.vehicles import VehicleId


@np.errstate(invalid="ignore", over="ignore")  # damaged values
def read_dataflash(log: OpenLog, _vehicle: VehicleId | None, progress: Progress | None) -> Recording:
    """Read the usable fixes of the one vehicle that wrote a log; see ``log_formats.Read``."""
    stream, collected = RecordStream(log, MESSAGES, progress), Collected()
    for block in stream.blocks():
        collected.add(block)
    if stream.formats.is_empty:
        raise LogError(
            f"{log.name} is a DataFlash log without any description of its records (FMT), as of a full "
            "or damaged card; it cannot be read, name another log"
        )
    unread = stream.length - stream.read_bytes
    return dataflash_recording(LogContents(log.name, stream.length, unread, collected, stream.restarts))
