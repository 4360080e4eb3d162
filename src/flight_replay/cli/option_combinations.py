"""Options that exclude each other, or have no effect together: told, not ignored."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

from flight_replay.planning.altitude import RECORDED

_OPTIONS = {
    "vehicle": "--vehicle",
    "flight": "--flight",
    "from_s": "--from",
    "to_s": "--to",
    "connect": "--connect",
    "floor_m": "--floor",
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
_RESULTS = "save", "plot", "report", "record", "map"
_PLANNED = "spacing_m", "max_points", "floor_m", "max_error_m", "takeoff_altitude_m"
_FLOWN = (*_PLANNED, *_IN_FLIGHT, "connect", "baud", "wait", "signing_key", "gcs", "sim", "sitl", "speedup")
"""What a log that is only looked at does not need."""


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
    _check_route(parser, values)
    _check_mode(parser, values)
    if values["info"]:
        _refuse(parser, values, (*_RESULTS, "dry_run"), "needs a plan and cannot be used with --info")
    if values["compare"]:
        if values["log"] is not None or values["tlog"] is not None:
            parser.error("--compare names both logs; leave out LOG and --tlog")
        _refuse(parser, values, (*_RESULTS, "dry_run", "info"), "cannot be used with --compare")


def without_effect(values: Mapping[str, object]) -> tuple[str, ...]:
    """A sentence for each option that is not needed: whoever looks before flying only adds an option.

    That is ``--dry-run``, or ``--info`` or ``--compare`` to look at logs alone.
    """
    ignored: tuple[str, ...]
    if values["dry_run"]:
        looks = "--dry-run"
        ignored = _IN_FLIGHT if values["connect"] is not None else (*_IN_FLIGHT, *_WITH_VEHICLE)
    elif values["info"]:
        looks, ignored = "--info", ("flight", "from_s", "to_s", *_FLOWN)
    elif values["compare"]:
        looks, ignored = "--compare", ("vehicle", *_FLOWN)
    else:
        return ()
    return tuple(
        f"{_OPTIONS[name]} has no effect with {looks}" for name in ignored if _is_given(values[name])
    )


def _is_given(value: object) -> bool:
    return value is not None and value is not False and value != ()


def _refuse(
    parser: argparse.ArgumentParser, values: Mapping[str, object], names: tuple[str, ...], why: str
) -> None:
    """Refuse the first of some options that was given."""
    for name in names:
        if _is_given(values[name]):
            parser.error(f"{_OPTIONS[name]} {why}")


def _check_vehicle(parser: argparse.ArgumentParser, values: Mapping[str, object]) -> None:
    """Refuse options of a simulator with a vehicle, and the other way round."""
    if values["connect"] is not None and (values["sim"] or values["sitl"]):
        parser.error("--sim and --sitl start a simulator and cannot be used with --connect")
    if values["connect"] is None:
        _refuse(parser, values, ("signing_key", "baud", "wait"), "is for a vehicle given with --connect")
    if values["sitl"] and values["sim"] == "builtin":
        parser.error("--sitl starts ArduPilot SITL and cannot be used with --sim builtin")
    if not values["gcs"]:
        _refuse(parser, values, ("gcs_open",), "is for ground stations given with --gcs")
    if not values["save"]:
        _refuse(parser, values, ("bare",), "is for missions saved with --save")
    elif values["bare"]:
        _check_bare(parser, values["save"])
    if not values["map"]:
        _refuse(parser, values, ("map_tiles",), "is for the live map and needs --map")


def _check_bare(parser: argparse.ArgumentParser, saved: Any) -> None:
    """Refuse ``--bare`` where no file has a take-off that it leaves out."""
    from flight_replay.mission.formats import LOADED_SUFFIXES

    if not any(path.suffix.lower() in LOADED_SUFFIXES for path in saved):
        parser.error(f"--bare is for missions saved as {' or '.join(LOADED_SUFFIXES)}")


def _check_route(parser: argparse.ArgumentParser, values: Mapping[str, object]) -> None:
    """Refuse options that are for another way of planning."""
    if values["altitude_m"] != RECORDED:
        _refuse(parser, values, ("floor_m",), "is for recorded altitudes and needs --altitude recorded")
    if values["route"] == "fit":
        _refuse(parser, values, ("spacing_m",), "is for --route spacing and cannot be used with --route fit")


def _check_mode(parser: argparse.ArgumentParser, values: Mapping[str, object]) -> None:
    """Refuse options that are for the other mode."""
    if values["mode"] == "auto":
        if values["pace"] != 1.0:
            parser.error("--speed with a factor needs --mode guided")
        _refuse(parser, values, ("max_error_m", "passes"), "needs --mode guided")
        return
    if values["limits"] == "recorded":
        parser.error("--limits recorded is for missions and cannot be used with --mode guided")
    if values["route"] == "fit":
        parser.error("--mode guided follows the recording without waypoints; leave out --route fit")
    without = "is for waypoints and cannot be used with --mode guided"
    _refuse(parser, values, ("spacing_m", "max_points"), without)
