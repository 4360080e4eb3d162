"""Options that exclude each other, or have no effect together: told, not ignored."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NoReturn

from flight_replay.planning.altitude import RECORDED
from flight_replay.simulator.server.addresses import is_serial_port

_OPTIONS = {
    "vehicle": "--vehicle",
    "flight": "--flight",
    "from_s": "--from",
    "to_s": "--to",
    "connect": "--connect",
    "mode": "--mode",
    "route": "--route",
    "altitude_m": "--altitude",
    "heading": "--heading",
    "duration_s": "--duration",
    "floor_m": "--floor",
    "speed_m_s": "--speed",
    "pace": "--speed with a factor",
    "limits": "--limits",
    "spacing_m": "--spacing",
    "max_points": "--max-points",
    "max_error_m": "--max-error",
    "passes": "--passes",
    "takeoff_altitude_m": "--takeoff-altitude",
    "max_distance_m": "--max-distance",
    "baud": "--baud",
    "wait": "--wait",
    "signing_key": "--signing-key",
    "gcs_open": "--gcs-open",
    "speedup": "--speedup",
    "sim": "--sim",
    "sitl": "--sitl",
    "land": "--land",
    "yes": "--yes",
    "record": "--record",
    "gcs": "--gcs",
    "save": "--save",
    "bare": "--bare",
    "plot": "--plot",
    "report": "--report",
    "map": "--map",
    "map_tiles": "--map-tiles",
    "dry_run": "--dry-run",
    "info": "--info",
}
_IN_FLIGHT = "land", "yes", "max_distance_m", "passes"
_WITH_VEHICLE = "record", "gcs", "sim", "sitl", "speedup"
_FILES = "save", "plot", "report", "record"
_RESULTS = (*_FILES, "map")
_PLANNED = "spacing_m", "max_points", "floor_m", "max_error_m", "takeoff_altitude_m"
_WITH_CONNECT = "connect", "baud", "wait", "signing_key", "gcs", "sim", "sitl", "speedup"
_ROUTE = "mode", "route", "altitude_m", "speed_m_s", "pace", "heading", "duration_s", "limits"
_FLOWN = (*_ROUTE, *_PLANNED, *_IN_FLIGHT, *_WITH_CONNECT)
"""What a log that is only looked at does not need."""
_Error = Callable[[str], NoReturn]


@dataclass(frozen=True, slots=True)
class Wording:
    """What options are called where they were given: by destination, and with a value."""

    names: Mapping[str, str]
    pattern: str

    def name(self, destination: str) -> str:
        """The option."""
        return self.names.get(destination, destination)

    def setting(self, destination: str, value: str) -> str:
        """The option with a value."""
        return self.pattern.format(self.name(destination), value)


COMMAND_LINE = Wording(_OPTIONS, "{} {}")
KEYWORDS = Wording({}, "{}={!r}")
"""Arguments of a function, which have the names of the destinations."""


def check_combinations(parser: argparse.ArgumentParser, values: Mapping[str, object]) -> None:
    """Refuse options that exclude each other, and those that would be ignored.

    Args:
        parser: Reports them.
        values: What was given, by destination: None or False where an option was not.
    """
    if values["log"] is not None and values["tlog"] is not None:
        parser.error("name one log: LOG and --tlog are the same")
    if values["verbose"] and values["quiet"]:
        parser.error("-v and -q cannot be used together")
    begin, end = values["from_s"], values["to_s"]
    if isinstance(begin, float) and isinstance(end, float) and begin >= end:
        parser.error(f"--from {begin:g} must be less than --to {end:g}")
    _check_vehicle(parser, values)
    check_route(parser.error, values)
    if values["info"]:
        _refuse(parser.error, values, (*_RESULTS, "dry_run"), "needs a plan and cannot be used with --info")
    if values["compare"]:
        if values["log"] is not None or values["tlog"] is not None:
            parser.error("--compare names both logs; leave out LOG and --tlog")
        _refuse(parser.error, values, (*_RESULTS, "dry_run", "info"), "cannot be used with --compare")


def without_effect(values: Mapping[str, object], defaults: Mapping[str, object]) -> tuple[str, ...]:
    """A sentence for each option that is not needed: whoever looks before flying only adds an option.

    That is ``--dry-run``, or ``--info`` or ``--compare`` to look at logs alone. A baud rate is for a serial
    port alone, ``--force`` for files.

    Args:
        values: What was given, by destination.
        defaults: What they are where nothing is given.
    """
    sentences = [
        f"{_OPTIONS[name]} has no effect with {other}"
        for other, ignored in _ignored_with(values)
        for name in ignored
        if values[name] != defaults[name]
    ]
    if values["force"] and not any(_is_given(values[name]) for name in _FILES):
        sentences.append("--force has no effect without an output file")
    return tuple(sentences)


def _ignored_with(values: Mapping[str, object]) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Options that are given, each with the destinations of those that it leaves without an effect."""
    if values["info"]:
        yield "--info", ("flight", "from_s", "to_s", *_FLOWN)
    elif values["compare"]:
        yield "--compare", ("vehicle", *_FLOWN)
    else:
        connection = values["connect"]
        if values["dry_run"]:
            yield "--dry-run", _IN_FLIGHT if connection is not None else (*_IN_FLIGHT, *_WITH_VEHICLE)
        if isinstance(connection, str) and values["baud"] is not None and not is_serial_port(connection):
            yield f"--connect {connection}", ("baud",)


def _is_given(value: object) -> bool:
    return value is not None and value is not False and value != ()


def _refuse(
    error: _Error,
    values: Mapping[str, object],
    names: tuple[str, ...],
    why: str,
    words: Wording = COMMAND_LINE,
) -> None:
    """Refuse the first of some options that was given."""
    for name in names:
        if _is_given(values[name]):
            error(f"{words.name(name)} {why}")


def _check_vehicle(parser: argparse.ArgumentParser, values: Mapping[str, object]) -> None:
    """Refuse options of a simulator with a vehicle, and the other way round."""
    if values["connect"] is not None and (values["sim"] or values["sitl"]):
        parser.error("--sim and --sitl start a simulator and cannot be used with --connect")
    if values["connect"] is None:
        _refuse(
            parser.error, values, ("signing_key", "baud", "wait"), "is for a vehicle given with --connect"
        )
    if values["sitl"] and values["sim"] == "builtin":
        parser.error("--sitl starts ArduPilot SITL and cannot be used with --sim builtin")
    if not values["gcs"]:
        _refuse(parser.error, values, ("gcs_open",), "is for ground stations given with --gcs")
    if not values["save"]:
        _refuse(parser.error, values, ("bare",), "is for missions saved with --save")
    elif values["bare"] or values["mode"] == "guided":
        _check_saved(parser, values, values["save"])
    if not values["map"]:
        _refuse(parser.error, values, ("map_tiles",), "is for the live map and needs --map")


def _check_saved(parser: argparse.ArgumentParser, values: Mapping[str, object], saved: Any) -> None:
    """Refuse ``--bare`` where no file has a take-off that it leaves out, and missions of what is none."""
    from flight_replay.mission.formats import LOADED_SUFFIXES

    missions = [path for path in saved if path.suffix.lower() in LOADED_SUFFIXES]
    if values["bare"] and not missions:
        parser.error(f"--bare is for missions saved as {' or '.join(LOADED_SUFFIXES)}")
    if values["mode"] == "guided" and missions:
        parser.error(
            f"--save {missions[0]} cannot be used with --mode guided: a motion that is followed is no "
            "mission; use --route fit --speed recorded instead"
        )


def check_route(error: _Error, values: Mapping[str, object], words: Wording = COMMAND_LINE) -> None:
    """Refuse options that are for another way of planning, or for the other mode.

    Args:
        error: Reports them.
        values: What was given, by destination.
        words: What it is called there.
    """
    recorded = words.setting("altitude_m", RECORDED)
    if values["altitude_m"] != RECORDED:
        why = f"is for recorded altitudes and needs {recorded}"
        _refuse(error, values, ("floor_m",), why, words)
    spacing, fit = words.setting("route", "spacing"), words.setting("route", "fit")
    guided = words.setting("mode", "guided")
    if values["route"] == "fit":
        why = f"is for {spacing} and cannot be used with {fit}"
        _refuse(error, values, ("spacing_m",), why, words)
        if values["max_points"] == 1:  # One place covers nothing of a flight.
            error(f"{fit} needs {words.name('max_points')} of 2 or more")
    if values["mode"] == "auto":
        if values["pace"] != 1.0:
            error(f"{words.name('pace')} needs {guided}")
        _refuse(error, values, ("max_error_m", "passes"), f"needs {guided}", words)
        return
    if values["limits"] == "recorded":
        error(f"{words.setting('limits', 'recorded')} is for missions and cannot be used with {guided}")
    if values["route"] == "fit":
        error(f"{guided} follows the recording without waypoints; leave out {fit}")
    why = f"is for waypoints and cannot be used with {guided}"
    _refuse(error, values, ("spacing_m", "max_points"), why, words)
