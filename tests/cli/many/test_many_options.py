"""The options of flight-replay-many, and the command that a row shows."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from flight_replay.cli.many import many_main
from flight_replay.cli.many.log_files import find_logs
from flight_replay.cli.many.many_options import build_many_parser, parse_many_options
from flight_replay.cli.options import parse_options
from flight_replay.output.many.fleet_comparison import Tolerance
from tests.helpers.paths import SAMPLE


def test_options_of_a_replay_are_handed_on_as_typed() -> None:
    typed = "logs --route fit --altitude recorded+10 --speed recorded --duration all --land"
    options = parse_many_options(shlex.split(typed))
    assert options.job.arguments == (
        "--route", "fit", "--altitude", "recorded+10", "--speed", "recorded", "--duration", "all", "--land",
    )  # fmt: skip
    again = parse_many_options(
        shlex.split("--land --duration all --speed recorded other --altitude recorded+10 --route fit")
    )
    assert again.job.options_id == options.job.options_id


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ("x", {"dry_run": True, "sim": "auto"}),
        ("x --fly model", {"dry_run": True}),
        ("x --fly builtin --speedup 20", {"dry_run": False, "sim": "builtin", "speedup": 20.0}),
        ("x --fly sitl --speedup 4 --mode guided", {"sim": "sitl", "speedup": 4.0, "mode": "guided"}),
    ],
)
def test_the_command_of_a_row_is_one_of_flight_replay(arguments: str, expected: dict[str, object]) -> None:
    job = parse_many_options(arguments.split()).job
    program, *words = shlex.split(job.replay_command("-a b.tlog", 3, 2))
    options = parse_options(words)
    assert program == "flight-replay"
    assert (options.log, options.vehicle, options.flight) == ("./-a b.tlog", (3, None), 2)
    assert {name: getattr(options, name) for name in expected} == expected


def test_another_binary_is_another_set_of_options_wherever_it_is(tmp_path: Path) -> None:
    ids = []
    for name, content in (("old", b"1"), ("moved", b"1"), ("new", b"2")):
        (tmp_path / name).write_bytes(content)
        options = parse_many_options(["x", "--fly", "sitl", "--sitl", str(tmp_path / name)])
        ids.append(options.job.options_id)
    assert ids[0] == ids[1] != ids[2]


@pytest.mark.parametrize(
    "wrong",
    [
        "",
        "x --compare a.csv b.csv",
        "x --sitl arducopter",
        "x --speedup 3",
        "x --redo-failed",
        "x --mode guided --route fit",
        "x --fly fast",
        "x --workers 0",
        "x -v -q",
        "x --tolerance 0.2",
        "x --tolerance-percent 5",
        "--compare a.csv b.csv --report c.html",
        "--compare a.csv b.csv --out c.csv",
        "--compare a.csv b.csv --fly model",
        "--compare a.csv b.csv --duration all",
    ],
)
def test_wrong_usage_is_refused(wrong: str) -> None:
    with pytest.raises(SystemExit) as stop:
        parse_many_options(wrong.split())
    assert stop.value.code == 2


def test_help_says_the_defaults_of_many_flights() -> None:
    """All vehicles and flights become rows, and there is no --connect."""
    text = " ".join(build_many_parser().format_help().split())
    assert text.count("(default: all of them)") == 2
    assert "--speedup X simulation speed as a multiple of real time (default: 1)" in text
    assert "--connect" not in text


def test_a_comparison_has_its_tolerances() -> None:
    """Those given, or the defaults that help names."""
    usual = parse_many_options(shlex.split("--compare a.csv b.csv --json -v"))
    assert usual.tolerance == Tolerance(0.2, 0.1)
    given = parse_many_options(shlex.split("--compare a.csv b.csv --tolerance 0 --tolerance-percent 5 -q"))
    assert given.tolerance == Tolerance(0.0, 0.05)


def test_logs_are_found_once_each_and_others_told(tmp_path: Path) -> None:
    for name in (
        "b/2.tlog",
        "b/1.BIN",
        "a/3.tlog.gz",
        "a/notes.txt",
        "a/.hidden.tlog",
        ".git/4.tlog",
        "out.csv",
    ):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    named = [str(tmp_path / "a" / "notes.txt"), str(tmp_path), "-"]
    lines = [f"{tmp_path}/b/2.tlog\n", "\n", "gone.tlog\r\n"]
    found = find_logs(named, lines, [tmp_path / "out.csv", None])
    names = [Path(each.path).name for each in found.files]
    assert names == ["notes.txt", "3.tlog.gz", "1.BIN", "2.tlog", "gone.tlog"]
    assert found.files[-1].bytes is None
    assert dict(found.passed_over) == {".txt": 1}


def test_without_dask_no_table_is_begun(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One without a row would be gone on with."""
    monkeypatch.setattr("flight_replay.cli.many.cluster.find_spec", lambda _name: None)
    assert many_main.main([str(SAMPLE), "--out", str(tmp_path / "flights.csv")]) == 1
    assert 'install it with: pip install "flight-replay[many]"' in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
