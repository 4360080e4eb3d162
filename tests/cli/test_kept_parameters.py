"""Parameters that are changed for a flight: a file keeps those of before until they are put back."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NoReturn

import pytest

from flight_replay.cli.kept_parameters import (
    kept_parameters,
    parameter_text,
    read_parameter_file,
    tell_of_changed_parameters,
)
from flight_replay.events import Event, Notice
from flight_replay.exceptions import FlightReplayError, VehicleError

WANTED = {"GUID_TIMEOUT": 0.5, "WPNAV_SPEED": 1200.0}


class FakeConnected:
    """A vehicle with parameters; ``restores`` is whether it takes those of before again."""

    def __init__(self, *, restores: bool = True) -> None:
        self.values = {"GUID_TIMEOUT": 3.0, "WPNAV_SPEED": 1000.0}
        self.restores = restores

    def parameters(self, names: Iterable[str]) -> dict[str, float]:
        return {name: self.values[name] for name in names if name in self.values}

    @contextmanager
    def parameters_set(
        self, wanted: Mapping[str, float], put_back: Callable[[Mapping[str, str]], None]
    ) -> Iterator[None]:
        before = self.parameters(wanted)
        self.values.update(wanted)
        try:
            yield
        finally:
            unset = {} if self.restores else {"GUID_TIMEOUT": "it stays 0.5"}
            self.values.update({name: value for name, value in before.items() if name not in unset})
            put_back(unset)
        if not self.restores:
            raise VehicleError("it stays 0.5")


def flown(connected: Any, folder: Path, during: Callable[[], None] = lambda: None) -> list[str]:
    """What is told of a flight with the parameters changed."""
    told: list[Event] = []
    with (
        suppress(VehicleError, KeyboardInterrupt),
        kept_parameters(connected, WANTED, folder, lambda path: f"restore {path.name}", told.append),
    ):
        during()
    assert all(isinstance(event, Notice) and event.warning for event in told)
    return [event.text for event in told if isinstance(event, Notice)]


def told_by_the_next_run(connected: Any, folder: Path) -> list[str]:
    """What the next run from a folder tells."""
    told: list[Event] = []
    tell_of_changed_parameters(connected, folder, lambda path: f"restore {path.name}", told.append)
    return [event.text for event in told if isinstance(event, Notice)]


def interrupt() -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize("during", [lambda: None, interrupt], ids=["flown", "interrupted"])
def test_the_file_is_there_only_during_the_flight(tmp_path: Path, during: Callable[[], None]) -> None:
    connected = FakeConnected()
    files: list[dict[str, float]] = []

    def look() -> None:
        files.extend(read_parameter_file(path) for path in tmp_path.iterdir())
        during()

    assert flown(connected, tmp_path, look) == []
    assert files == [{"GUID_TIMEOUT": 3.0, "WPNAV_SPEED": 1000.0}]
    assert list(tmp_path.iterdir()) == []
    assert connected.values["GUID_TIMEOUT"] == 3.0
    assert told_by_the_next_run(connected, tmp_path) == []


@pytest.mark.parametrize("during", [lambda: None, interrupt], ids=["flown", "interrupted"])
def test_what_is_not_put_back_is_told_with_the_command(tmp_path: Path, during: Callable[[], None]) -> None:
    """At once, and it alone; and again by the next run, until it is as before."""
    connected = FakeConnected(restores=False)
    (told,) = flown(connected, tmp_path, during)
    (path,) = tmp_path.iterdir()
    assert told.startswith("GUID_TIMEOUT may not be as before")
    assert told.endswith(f"restore {path.name}")
    (again,) = told_by_the_next_run(connected, tmp_path)
    assert "GUID_TIMEOUT 0.5 instead of 3" in again
    assert again.endswith(f"restore {path.name}")
    connected.values.update(read_parameter_file(path))
    assert told_by_the_next_run(connected, tmp_path) == []


def test_nothing_is_kept_for_a_vehicle_that_is_not_changed(tmp_path: Path) -> None:
    """It was armed meanwhile: neither a file nor a warning of parameters that were never set."""

    class Armed(FakeConnected):
        def parameters_set(self, *_: object) -> NoReturn:
            raise VehicleError("the vehicle is armed")

    assert flown(Armed(), tmp_path, pytest.fail) == []
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_kept_where_nothing_changes(tmp_path: Path) -> None:
    connected = FakeConnected(restores=False)
    connected.values |= WANTED
    assert flown(connected, tmp_path, lambda: pytest.fail() if list(tmp_path.iterdir()) else None) == []


def test_files_of_ground_stations_are_read(tmp_path: Path) -> None:
    path = tmp_path / "a.param"
    path.write_text("# mine\nWPNAV_SPEED,1500\n\nGUID_TIMEOUT 3 # seconds\n")
    assert read_parameter_file(path) == {"WPNAV_SPEED": 1500.0, "GUID_TIMEOUT": 3.0}
    path.write_text(parameter_text({"ANGLE_MAX": 4500.0, "A": 1 / 3}))
    assert read_parameter_file(path) == pytest.approx({"ANGLE_MAX": 4500.0, "A": 1 / 3})


@pytest.mark.parametrize("text", ["GUID_TIMEOUT\n", "GUID_TIMEOUT three\n", "A 1 2\n"])
def test_other_files_are_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.parm"
    path.write_text("B 2\n" + text)
    with pytest.raises(FlightReplayError, match="line 2: not a name and a number"):
        read_parameter_file(path)
    with pytest.raises(FlightReplayError, match="cannot read"):
        read_parameter_file(tmp_path / "none.parm")


def test_a_file_that_cannot_be_read_or_deleted_does_not_keep_a_flight(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The next run says which one it is; a flight ends as it did."""
    (tmp_path / "parameters-before-20260101-000000.parm").write_text("GUID_TIMEOUT three\n")
    (told,) = told_by_the_next_run(FakeConnected(), tmp_path)
    assert "parameters-before-20260101-000000.parm, line 1" in told

    def fails(_path: Path, *, missing_ok: bool = False) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "unlink", fails)
    assert flown(FakeConnected(), tmp_path) == []
