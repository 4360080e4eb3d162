"""options.py, option_groups.py and option_types.py: options become plain data, or wrong usage."""

from pathlib import Path

import pytest

from flight_replay.cli.options import build_parser, parse_options


def test_defaults_are_those_of_dronekits_example() -> None:
    """Without options the replay does what the example does."""
    options = parse_options([])
    assert (options.log, options.connect, options.sim) == (None, None, "auto")
    assert (options.route, options.spacing_m, options.max_points) == ("spacing", 3.0, 100)
    assert (options.altitude_m, options.speed_m_s, options.duration_s) == (30.0, None, 60.0)
    assert (options.takeoff_altitude_m, options.max_distance_m, options.speedup) == (30.0, 1000.0, None)


@pytest.mark.parametrize(
    ("argv", "name", "value"),
    [
        (["--vehicle", "10"], "vehicle", (10, None)),
        (["--vehicle", "1:191"], "vehicle", (1, 191)),
        (["--altitude", "recorded"], "altitude_m", "recorded"),
        (["--altitude", "recorded"], "floor_m", 5.0),
        (["--altitude", "recorded", "--floor", "2.5"], "floor_m", 2.5),
        (["--altitude", "12.5"], "altitude_m", 12.5),
        (["--speed", "vehicle"], "speed_m_s", None),
        (["--speed", "recorded"], "speed_m_s", "recorded"),
        (["--speed", "4"], "speed_m_s", 4.0),
        (["--duration", "all"], "duration_s", None),
        (["--duration", "90"], "duration_s", 90.0),
        (["--save", "a.plan", "--save", "b.kml"], "save", (Path("a.plan"), Path("b.kml"))),
        (["--gcs", "udp:127.0.0.1:14551"], "gcs", ("udp:127.0.0.1:14551",)),
        (["--sitl", "arducopter"], "sim", "sitl"),
        (["--connect", "x", "--signing-key", "key"], "signing_key", Path("key")),
    ],
)
def test_values_are_read(argv: list[str], name: str, value: object) -> None:
    """Each value is in SI units under a name that says so."""
    assert getattr(parse_options(argv), name) == value


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["--vehicle", "300"], "SYSID"),
        (["--vehicle", "1:"], "SYSID"),
        (["--flight", "0"], "whole number of 1 or more"),
        (["--spacing", "-1"], "must be 0 or more, not -1"),
        (["--spacing", "nan"], "finite"),
        (["--altitude", "high"], "must be a number, recorded or recorded+M, not 'high'"),
        (["--speed", "4m/s"], "must be a number, vehicle, recorded or a factor such as 0.5x, not '4m/s'"),
        (["--duration", "whole"], "must be a number or all, not 'whole'"),
        (["--speed", "0"], "greater than 0"),
        (["--duration", "-5"], "greater than 0"),
        (["--max-points", "1.5"], "whole number"),
        (["--max-points", str(10**9)], "--max-points: must be 32000 or less"),
        (["--max-points", "9" * 5000], "must be a whole number of 1 or more, not '9999"),
        (["--flight", "²"], "must be a whole number of 1 or more, not '²'"),
        (["--vehicle", "²"], "each 0 to 255, not '²'"),
        (["--vehicle", "9" * 5000], "each 0 to 255, not '9999"),
        (["--baud", str(10**30)], "whole number"),
        (["--baud", str(10**9)], "--baud: must be 10000000 or less"),
        (["--speed", "1e300"], r"--speed: must be 300 or less, not 1e+300"),
        (["--speed", "0.19"], "--speed: must be 0.2 or more, not 0.19"),
        (["--altitude", "1e300"], "--altitude: must be 80000 or less"),
        (["--takeoff-altitude", "1e300"], "--takeoff-altitude: must be 80000 or less"),
        (["--speedup", "1e300"], "--speedup: must be 1000 or less"),
        (["--speedup", "1e-300"], "--speedup: must be 0.01 or more"),
        (["--duration", "1e300"], "--duration: must be 1000000 or less"),
        (["--from", "20", "--to", "10"], "--from 20 must be less than --to 10"),
        (["--altitude", "recorded", "--floor", "0"], "--floor: must be greater than 0"),
        (["--altitude", "recorded", "--floor", "nan"], "--floor: must be a finite number"),
        (["--altitude", "recorded", "--floor", "1e300"], "--floor: must be 80000 or less"),
        (["--floor", "3"], "--floor is for recorded altitudes and needs --altitude recorded"),
        (["--connect", "x", "--sim", "sitl"], "cannot be used with --connect"),
        (["--connect", "x", "--sitl", "y"], "cannot be used with --connect"),
        (["--sim", "builtin", "--sitl", "y"], "cannot be used with --sim builtin"),
        (["--signing-key", "key"], "--signing-key is for a vehicle given with --connect"),
        (["--baud", "9600"], "--baud is for a vehicle given with --connect"),
        (["--wait"], "--wait is for a vehicle given with --connect"),
        (["--gcs-open"], "--gcs-open is for ground stations given with --gcs"),
        (["--bare", "--save", "a.kml"], "--bare is for missions saved as .waypoints or .plan"),
        (["--map-tiles"], "--map-tiles is for the live map and needs --map"),
        (["--route", "fit", "--spacing", "3"], "--spacing is for --route spacing"),
        (["--route", "fit", "--max-points", "1"], "--route fit needs --max-points of 2 or more"),
        (["--mode", "guided", "--max-points", "9"], "--max-points is for waypoints"),
        (["--max-error", "2"], "--max-error needs --mode guided"),
        (["--passes", "2"], "--passes needs --mode guided"),
        (["--mode", "guided", "--passes", "0"], "--passes: must be a whole number of 1 or more"),
        (["--info", "--save", "a.kml"], "--save needs a plan and cannot be used with --info"),
        (["a.tlog", "--tlog", "b.tlog"], "name one log: LOG and --tlog are the same"),
        (["-v", "-q"], "-v and -q cannot be used together"),
        (["--tl", "x"], "unrecognized"),
    ],
)
def test_wrong_usage_has_a_message(argv: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The exit status is 2, and the message names the option."""
    with pytest.raises(SystemExit) as stop:
        parse_options(argv)
    assert stop.value.code == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("argv", "told"),
    [
        (["--info", "--flight", "3", "--vehicle", "1"], ("--flight has no effect with --info",)),
        (
            ["--info", "--connect", "x", "--land"],
            ("--land has no effect with --info", "--connect has no effect with --info"),
        ),
        (
            ["--info", "--route", "fit", "--duration", "all"],
            ("--route has no effect with --info", "--duration has no effect with --info"),
        ),
        (["--compare", "a", "b", "--vehicle", "1"], ("--vehicle has no effect with --compare",)),
        (
            ["--connect", "tcp:localhost:5760", "--baud", "57600"],
            ("--baud has no effect with --connect tcp:localhost:5760",),
        ),
        (["--connect", "/dev/serial/by-path/usb-0:2:1.0", "--baud", "57600"], ()),
        (["--compare", "a", "b", "--flight", "2", "--from", "3"], ()),
        (["--bare", "--save", "a.kml", "--save", "a.plan"], ()),
        (["--force"], ("--force has no effect without an output file",)),
        (["--force", "--info"], ("--force has no effect without an output file",)),
        (["--force", "--record", "a.tlog"], ()),
    ],
)
def test_what_has_no_effect_is_told(argv: list[str], told: tuple[str, ...]) -> None:
    """Whoever only looks at a log goes on, with a word."""
    assert parse_options(argv).without_effect == told


def test_version_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    """--version prints the program's name and version."""
    with pytest.raises(SystemExit) as stop:
        parse_options(["--version"])
    assert stop.value.code == 0
    assert capsys.readouterr().out.startswith("flight-replay ")


def test_every_group_has_an_example() -> None:
    """The example in the help of each group can be parsed."""
    groups = [group for group in build_parser()._action_groups if group.description]
    assert len(groups) == 5
    for group in groups:
        assert group.description is not None
        command = group.description.partition("flight-replay ")[2].partition(" >")[0]
        parse_options(command.split())


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_a_completion_script_is_printed(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    """It has the options in it."""
    with pytest.raises(SystemExit) as stop:
        parse_options(["--print-completion", shell])
    assert stop.value.code == 0
    assert "takeoff-altitude" in capsys.readouterr().out


@pytest.mark.parametrize(
    "argv",
    [["a.tlog", "\x1b[31m"], ["--speed", "\x1b[31m"], ["--route", "\x1b[31m"], ["--\x1b[31m"]],
    ids=str,
)
def test_wrong_usage_cannot_control_the_terminal(argv: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """What was typed, perhaps by pasting, is repeated with escapes."""
    with pytest.raises(SystemExit):
        parse_options(argv)
    written = capsys.readouterr().err
    assert "\x1b" not in written
    assert r"\x1b[31m" in written
