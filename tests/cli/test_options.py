"""Options are parsed into plain data, and nonsense is wrong usage."""

from pathlib import Path

import pytest

from flight_replay.cli.options import build_parser, parse


def test_defaults_are_the_design_s() -> None:
    """A bare command line is the example's behaviour."""
    options = parse([])
    assert (options.tlog, options.connect, options.sim) == (None, None, "auto")
    assert (options.route, options.spacing_m, options.max_points) == ("spacing", 3.0, 100)
    assert (options.altitude_m, options.speed_m_s, options.duration_s) == (30.0, None, 60.0)
    assert (options.takeoff_altitude_m, options.max_distance_m, options.speedup) == (30.0, 1000.0, None)


@pytest.mark.parametrize(
    ("argv", "name", "value"),
    [
        (["--vehicle", "10"], "vehicle", (10, None)),
        (["--vehicle", "1:191"], "vehicle", (1, 191)),
        (["--altitude", "recorded"], "altitude_m", "recorded"),
        (["--altitude", "12.5"], "altitude_m", 12.5),
        (["--speed", "vehicle"], "speed_m_s", None),
        (["--speed", "recorded"], "speed_m_s", "recorded"),
        (["--speed", "4"], "speed_m_s", 4.0),
        (["--duration", "all"], "duration_s", None),
        (["--duration", "90"], "duration_s", 90.0),
        (["--save", "a.plan", "--save", "b.kml"], "save", (Path("a.plan"), Path("b.kml"))),
        (["--gcs", "udp:127.0.0.1:14551"], "gcs", ("udp:127.0.0.1:14551",)),
        (["--sitl", "arducopter"], "sim", "sitl"),
    ],
)
def test_values_are_read(argv: list[str], name: str, value: object) -> None:
    """Each value arrives in SI units under a name that says so."""
    assert getattr(parse(argv), name) == value


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (["--vehicle", "300"], "SYSID"),
        (["--vehicle", "1:"], "SYSID"),
        (["--flight", "0"], "whole number from 1"),
        (["--spacing", "-1"], "below 0"),
        (["--spacing", "nan"], "finite"),
        (["--altitude", "high"], "not a number"),
        (["--speed", "0"], "above 0"),
        (["--duration", "-5"], "above 0"),
        (["--max-points", "1.5"], "whole number"),
        (["--from", "20", "--to", "10"], "--from 20 is not before --to 10"),
        (["--connect", "x", "--sim", "sitl"], "--connect names a vehicle"),
        (["--connect", "x", "--sitl", "y"], "--connect names a vehicle"),
        (["--sim", "builtin", "--sitl", "y"], "--sitl names an ArduPilot binary"),
        (["-v", "-q"], "opposite"),
        (["--tl", "x"], "unrecognized"),
    ],
)
def test_wrong_usage_names_the_thing(argv: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Wrong usage is exit status 2 and a message that names what is wrong."""
    with pytest.raises(SystemExit) as stop:
        parse(argv)
    assert stop.value.code == 2
    assert words in capsys.readouterr().err


def test_version_is_the_package_s(capsys: pytest.CaptureFixture[str]) -> None:
    """--version says the program's name and version."""
    with pytest.raises(SystemExit) as stop:
        parse(["--version"])
    assert stop.value.code == 0
    assert capsys.readouterr().out.startswith("flight-replay ")


def test_every_group_has_an_example() -> None:
    """Each group of the help shows a command line that the parser takes."""
    groups = [group for group in build_parser()._action_groups if group.description]
    assert len(groups) == 5
    for group in groups:
        assert group.description is not None
        command = group.description.partition("flight-replay ")[2].partition(" >")[0]
        parse(command.split())


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_options_complete_in_a_shell(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The completion script knows the options and says nothing else."""
    with pytest.raises(SystemExit) as stop:
        parse(["--print-completion", shell])
    assert stop.value.code == 0
    assert "takeoff-altitude" in capsys.readouterr().out
