"""whole_flight.py: the command that flies the rest, as a person would type it."""

import pytest

from flight_replay.cli.options import parse_options
from flight_replay.cli.whole_flight import repeat_arguments, whole_flight_command

ALL = ("--route fit", "--duration all")


@pytest.mark.parametrize(
    ("arguments", "fly_all", "command"),
    [
        ([], ALL, "flight-replay --route fit --duration all"),
        (["a b.tlog"], ALL[1:], "flight-replay 'a b.tlog' --duration all"),
        (["--duration", "5", "--speedup", "10"], ALL[1:], "flight-replay --speedup 10 --duration all"),
        (["--duration=5", "--spacing=2", "x.bin"], ALL, "flight-replay x.bin --route fit --duration all"),
        (["--save", "m.kml"], ALL[1:], "flight-replay --save m.kml --duration all --force"),
        (["--plot=m.png", "--force"], ALL[1:], "flight-replay --plot=m.png --force --duration all"),
        (["--speedup", "9", "--", "-a"], ALL[1:], "flight-replay --speedup 9 --duration all -- -a"),
        (["--max-points", "1", "-q"], ALL, "flight-replay -q --route fit --duration all"),
        (["--max-points=1"], ALL, "flight-replay --route fit --duration all"),
        (["--max-points", "9"], ALL, "flight-replay --max-points 9 --route fit --duration all"),
        (["--max-points=9"], ALL, "flight-replay --max-points=9 --route fit --duration all"),
        (["--route", "spacing", "--spacing", "2"], ALL, "flight-replay --route fit --duration all"),
    ],
)
def test_options_take_the_place_of_those_given(
    arguments: list[str], fly_all: tuple[str, ...], command: str
) -> None:
    """And what they make useless goes; what the run wrote is replaced."""
    assert whole_flight_command(arguments, fly_all) == command
    parse_options(command.replace("'a b.tlog'", "a").split()[1:])


@pytest.mark.parametrize(
    ("arguments", "again"),
    [
        (["--dry-run", "-q"], ["--dry-run", "-q"]),
        (["--dry-run", "--report", "s.html"], ["--dry-run", "--report", "s.html", "--force"]),
        (["--force", "--plot=m.png"], ["--force", "--plot=m.png"]),
        (["--save", "m.kml", "--", "--force"], ["--save", "m.kml", "--force", "--", "--force"]),
    ],
)
def test_a_run_is_repeated_over_the_files_that_it_wrote(arguments: list[str], again: list[str]) -> None:
    """Only then is there anything to replace."""
    assert repeat_arguments(arguments) == again
