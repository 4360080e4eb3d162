"""``flight-replay-sim``: the built-in copter alone, for any ground station or script."""

from __future__ import annotations

import argparse
import math
import signal
import sys
from collections.abc import Sequence
from importlib.metadata import version
from types import FrameType

from flight_replay.exceptions import SimulatorError
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.server.addresses import parse_address
from flight_replay.writing.terminal_text import Parser, escaped

DEFAULT_LISTEN = "tcp:127.0.0.1:5760"
# Where ArduPilot's own SITL starts: the Canberra Model Aircraft Club.
DEFAULT_HOME = Start(-35.363262, 149.165237, 584.0, 353.0)
_MIN_SPEEDUP, _MAX_SPEEDUP = 0.01, 1000.0
_LOWEST_M, _HIGHEST_M = -1_000.0, 10_000.0
"""No ground is lower or higher; what the copter tells of its height has its bounds, too."""


def home(text: str) -> Start:
    """Parse LAT,LON,ALT,HDG; altitude and heading may be left out."""
    try:
        lat_deg, lon_deg, *rest = (float(part) for part in text.split(","))
        alt_m, heading_deg = (*rest, 0.0, 0.0)[:2]
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not LAT,LON,ALT,HDG in degrees and metres") from None
    valid = abs(lat_deg) <= 90 and abs(lon_deg) <= 180 and _LOWEST_M <= alt_m <= _HIGHEST_M
    if not valid or not math.isfinite(heading_deg) or len(rest) > 2:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not a valid position; use LAT,LON,ALT,HDG in degrees and metres"
        )
    return Start(lat_deg, lon_deg, alt_m, heading_deg)


def address(text: str) -> str:
    """Check an address, and write it in full."""
    try:
        return str(parse_address(text))
    except SimulatorError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def speedup(text: str) -> float:
    """Parse a factor that the simulator can keep to."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not _MIN_SPEEDUP <= value <= _MAX_SPEEDUP:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not a valid speedup; use {_MIN_SPEEDUP:g} to {_MAX_SPEEDUP:g}"
        )
    return value


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="flight-replay-sim",
        description="A simulated ArduCopter for any MAVLink ground station or script.",
    )
    parser.add_argument(
        "--listen",
        action="append",
        type=address,
        metavar="ADDRESS",
        help="tcp:HOST:PORT accepts any number of clients, udpin:HOST:PORT listens for datagrams, "
        f"udpout:HOST:PORT sends there; repeatable, port 0 takes a free one (default: {DEFAULT_LISTEN})",
    )
    parser.add_argument(
        "--home",
        type=home,
        default=DEFAULT_HOME,
        metavar="LAT,LON,ALT,HDG",
        help="position on the ground: degrees, metres above mean sea level, heading in degrees "
        "(default: that of ArduPilot's SITL)",
    )
    parser.add_argument(
        "--speedup",
        type=speedup,
        default=1.0,
        metavar="X",
        help="how many times faster than real time it runs; SIM_SPEEDUP changes it in flight (default: 1)",
    )
    parser.add_argument(
        "--version",
        action="version",
        version=f"%(prog)s {version('flight-replay')}",
        help="show the version and exit",
    )
    return parser


def _join_home(argv: Sequence[str]) -> list[str]:
    """``--home`` and its value joined: argparse takes -35.4,149.2 for an option."""
    words = list(argv)
    while "--home" in words[:-1]:
        at = words.index("--home")
        words[at : at + 2] = [f"--home={words[at + 1]}"]
    return words


class _Signals:
    """The signal that asked the program to end, once it has come."""

    def __init__(self) -> None:
        self.received: int | None = None
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._note)

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.received = number

    def was_received(self) -> bool:
        """Whether a signal has come."""
        return self.received is not None


def main(argv: Sequence[str] | None = None) -> int:
    """Run until Ctrl-C or SIGTERM.

    Returns:
        1 if it cannot start, with one line on stderr; 128 plus the signal's number when it was stopped.
    """
    options = _parser().parse_args(_join_home(sys.argv[1:] if argv is None else argv))
    signals = _Signals()
    # Only after the options are known to be valid: these import the MAVLink dialect, which takes time.
    from flight_replay.simulator.server.settings import Settings, open_endpoint

    listen = tuple(options.listen or [DEFAULT_LISTEN])
    try:
        endpoint = open_endpoint(Settings(options.home, listen, {"SIM_SPEEDUP": options.speedup}))
    except SimulatorError as error:
        sys.stderr.write(f"flight-replay-sim: error: {escaped(str(error))}\n")
        return 1
    try:
        for address in endpoint.addresses:
            verb = "sending to" if address.kind == "udpout" else "listening on"
            sys.stdout.write(f"{verb} {escaped(str(address))}\n")
        sys.stdout.flush()
        endpoint.run(signals.was_received)
    finally:
        endpoint.close()
    return 128 + (signals.received or 0)
