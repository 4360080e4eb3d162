"""The failures that this program expects; ``cli.py`` turns each into one line and exit status 1.

Every message is one sentence that names the thing that failed and the next step.
"""


class FlightReplayError(Exception):
    """Base of every expected failure."""


class LogError(FlightReplayError):
    """A log cannot be read, or holds nothing that can be flown."""


class MissionError(FlightReplayError):
    """A route cannot be planned, written, read or accepted."""


class VehicleError(FlightReplayError):
    """The vehicle, or the link to it, refused or failed."""


class PhaseTimeoutError(VehicleError):
    """A phase of the flight did not end before its deadline."""


class SimulatorError(FlightReplayError):
    """A simulator cannot be found, started or kept running."""
