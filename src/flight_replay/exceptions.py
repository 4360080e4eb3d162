"""The failures that the program expects. The command line prints each as one line and exits with 1.

A message names what failed, then the reason, then what to do next.
"""

from __future__ import annotations


class FlightReplayError(Exception):
    """Base class of every expected failure."""


class LogError(FlightReplayError):
    """A log cannot be read, or has nothing in it to fly."""


class MissionError(FlightReplayError):
    """A mission cannot be planned, read, written or flown."""


class VehicleError(FlightReplayError):
    """The vehicle, or the link to it, failed or refused a command."""


class PhaseTimeoutError(VehicleError):
    """A phase of the flight did not complete before its deadline."""


class LinkFaultError(VehicleError):
    """An error of the program itself keeps it from hearing the vehicle."""


class SimulatorError(FlightReplayError):
    """A simulator cannot be found or started, or stopped running."""


def failure_text(error: BaseException) -> str:
    """What a command says of an error that ends it; one that is not expected is an error of the program."""
    if isinstance(error, FlightReplayError):
        return str(error)
    return f"internal error ({type(error).__name__}: {error}); please report it with the output of -v"
