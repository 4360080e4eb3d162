"""``flight-replay-sim``: the built-in copter alone, for any ground station or script."""

from __future__ import annotations

import argparse
import math
import signal
import sys
from collections.abc import Sequence
from importlib.metadata import version
from types import FrameType

from flight_replay.errors import SimulatorError
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.server.addresses import parse_address

DEFAULT_LISTEN = "tcp:127.0.0.1:5760"
# Where ArduPilot's own SITL starts: the Canberra Model Aircraft Club.
DEFAULT_HOME = Start(-35.363262, 149.165237, 584.0, 353.0)
_FASTEST = 1000.0


def home(text: str) -> Start:
    """LAT,LON,ALT,HDG; altitude and heading may be left out."""
    try:
        lat_deg, lon_deg, *rest = (float(part) for part in text.split(","))
        alt_m, heading_deg = (*rest, 0.0, 0.0)[:2]
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not LAT,LON,ALT,HDG in degrees and metres") from None
    sane = abs(lat_deg) <= 90 and abs(lon_deg) <= 180 and all(map(math.isfinite, (alt_m, heading_deg)))
    if not sane or len(rest) > 2:
        raise argparse.ArgumentTypeError(f"'{text}' is no place on earth; give LAT,LON,ALT,HDG")
    return Start(lat_deg, lon_deg, alt_m, heading_deg)


def address(text: str) -> str:
    """A connection string that can be listened on."""
    try:
        return str(parse_address(text))
    except SimulatorError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def speedup(text: str) -> float:
    """A factor above 0."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value <= _FASTEST:
        raise argparse.ArgumentTypeError(
            f"'{text}' is no speedup; give a number above 0, at most {_FASTEST:g}"
        )
    return value


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="flight-replay-sim",
        description="A simulated ArduCopter for any MAVLink ground station or script.",
    )
    parser.add_argument(
        "--listen",
        action="append",
        type=address,
        metavar="ADDRESS",
        help=f"tcp:HOST:PORT waits for any number of clients, udp:HOST:PORT sends there, udpin:HOST:PORT "
        f"waits for a first datagram; repeatable, port 0 is any free one (default: {DEFAULT_LISTEN})",
    )
    parser.add_argument(
        "--home",
        type=home,
        default=DEFAULT_HOME,
        metavar="LAT,LON,ALT,HDG",
        help="where it stands: degrees, metres above sea level, degrees from north "
        "(default: where ArduPilot's SITL starts)",
    )
    parser.add_argument(
        "--speedup",
        type=speedup,
        default=1.0,
        metavar="X",
        help="vehicle seconds per second; SIM_SPEEDUP changes it in flight (default: 1)",
    )
    parser.add_argument("--version", action="version", version=f"%(prog)s {version('flight-replay')}")
    return parser


def _joined(argv: Sequence[str]) -> list[str]:
    """``--home`` and its value as one word: argparse takes -35.4,149.2 for an option of its own."""
    words = list(argv)
    while "--home" in words[:-1]:
        at = words.index("--home")
        words[at : at + 2] = [f"--home={words[at + 1]}"]
    return words


class _Signals:
    """Remembers the signal that asked for the end."""

    def __init__(self) -> None:
        self.received: int | None = None
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._note)

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.received = number

    def is_over(self) -> bool:
        """Whether the end was asked for."""
        return self.received is not None


def main(argv: Sequence[str] | None = None) -> int:
    """Run until Ctrl-C or SIGTERM.

    Returns:
        1 if it cannot start, told in one line; 128 and the signal's number when stopped by one.
    """
    options = _parser().parse_args(_joined(sys.argv[1:] if argv is None else argv))
    signals = _Signals()
    # Not before the options are known to be good: these import the MAVLink dialect.
    from flight_replay.simulator.server.settings import Settings, open_endpoint

    listen = tuple(options.listen or [DEFAULT_LISTEN])
    try:
        endpoint = open_endpoint(Settings(options.home, listen, {"SIM_SPEEDUP": options.speedup}))
    except SimulatorError as error:
        sys.stderr.write(f"flight-replay-sim: error: {error}\n")
        return 1
    try:
        for address in endpoint.addresses:
            verb = "sending to" if address.kind == "udpout" else "listening on"
            sys.stdout.write(f"{verb} {address}\n")
        sys.stdout.flush()
        endpoint.run(signals.is_over)
    finally:
        endpoint.close()
    return 128 + (signals.received or 0)
