"""Options from the keyword arguments of a program, checked as those of the command line are."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from numbers import Integral, Real
from typing import Any, NoReturn

from flight_replay.cli import option_types
from flight_replay.cli.option_combinations import KEYWORDS, check_route
from flight_replay.cli.options import DEFAULTS, Options, build_parser, parse_options
from flight_replay.cli.plan_step import needs_times
from flight_replay.exceptions import MissionError
from flight_replay.logs.track import Track
from flight_replay.planning.altitude import RECORDED

_MAY_BE_NONE = "connect", "duration_s", "heading", "speed_m_s", "speedup"
_MAY_BE_RECORDED = "altitude_m", "speed_m_s"


def keyword_options(arguments: Mapping[str, object]) -> Options:
    """The options of arguments that are called as the fields of ``Options``, all others as by default.

    Raises:
        MissionError: One is not what it may be.
    """
    checked = {name: _checked(name, value) for name, value in arguments.items()}
    options = replace(parse_options([]), **checked)
    if options.heading is None:
        return replace(options, heading="recorded" if options.mode == "guided" else "vehicle")
    return options


def check_planning(options: Options, track: Track) -> None:
    """Refuse what is no track with fixes, and options that do not go together or that need times it has not.

    Raises:
        MissionError: There are some.
    """
    check_kind(track, Track, "track", "read_log(path).track")
    if not len(track):
        _refuse("the track has no fix; choose another part of the recording")
    # A function cannot tell a default that was typed from one that was not.
    not_given = {name: None for name, default in DEFAULTS.items() if getattr(options, name) == default}
    names = ("route", "mode", "altitude_m", "pace", "limits", *DEFAULTS)
    check_route(_refuse, {name: getattr(options, name) for name in names} | not_given, KEYWORDS)
    needs = needs_times(options, KEYWORDS)
    if needs and not track.timed:
        _refuse(f"the track has no times: leave out {needs}")


def check_kind(value: object, kind: type, name: str, example: str) -> None:
    """Refuse an argument that is of another kind, as a recording where its track is wanted.

    Raises:
        MissionError: It is.
    """
    if not isinstance(value, kind):
        _refuse(f"{name} must be a {kind.__name__}, such as {example}, not {_quoted(value)}")


def _refuse(why: str) -> NoReturn:
    raise MissionError(why)


def _checked(name: str, value: object) -> Any:
    """The value of an argument, if the option of that name may have it."""
    if value is None and name in _MAY_BE_NONE:
        return None
    action = _actions()[name]
    if action.nargs == 0:
        return _one_of(name, value, (True, False))
    if action.choices is not None:
        return _one_of(name, value, tuple(action.choices))
    if name in _MAY_BE_RECORDED and isinstance(value, str) and value == RECORDED:
        return RECORDED
    if not callable(action.type):
        return value
    return _number(name, value, action.type)


def _one_of(name: str, value: object, choices: tuple[object, ...]) -> object:
    if not any(isinstance(value, type(choice)) and value == choice for choice in choices):
        _refuse(f"{name} must be {' or '.join(map(repr, choices))}, not {_quoted(value)}")
    return value


def _number(name: str, value: object, parse: Callable[[str], Any]) -> Any:
    """A number, read from its text as an option's value is: so it has the same limits, and messages."""
    if isinstance(value, bool) or not isinstance(value, Real):
        words = " or 'recorded'" if name in _MAY_BE_RECORDED else ""
        _refuse(f"{name} must be a number{words}, not {_quoted(value)}")
    try:
        parsed = parse(str(int(value)) if isinstance(value, Integral) else repr(float(value)))
    except argparse.ArgumentTypeError as error:
        raise MissionError(f"{name} {error}") from None
    return parsed[0] if isinstance(parsed, tuple) else parsed


def _quoted(value: object) -> str:
    """A value in one line."""
    return repr(value) if isinstance(value, str | Real | None) else f"a {type(value).__name__}"


@cache
def _actions() -> dict[str, argparse.Action]:
    """The options of the command line by destination; the pace is part of another one there."""
    pace = argparse.Action([], "pace", type=option_types.pace)
    return {action.dest: action for action in (*build_parser()._actions, pace)}
