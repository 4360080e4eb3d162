"""The command that repeats a run, and the one that flies all of the recorded flight, out of the run's own."""

from __future__ import annotations

import shlex
from collections.abc import Sequence, Set
from itertools import islice

_WRITES = ("--save", "--record", "--plot", "--report")


def repeat_arguments(arguments: Sequence[str]) -> list[str]:
    """The arguments of a run with which it can be repeated: the files that it wrote are replaced."""
    end = _end_of_options(arguments)
    options = arguments[:end]
    wrote = any(argument.split("=")[0] in _WRITES for argument in options)
    force = ["--force"] if wrote and "--force" not in options else []
    return [*options, *force, *arguments[end:]]


def whole_flight_command(arguments: Sequence[str], fly_all: Sequence[str]) -> str:
    """The command line of a run, with the options that fly all of the recording.

    The files that the run wrote are replaced by those of the whole flight.

    Args:
        arguments: Those of the run, without the program's name.
        fly_all: Options with their values, such as "--duration all"; they take the place of those given.
    """
    end = _end_of_options(arguments)
    replaced = {option.split()[0] for option in fly_all}
    kept = _without(arguments[:end], replaced)
    if "--route" in replaced:
        kept = _without(kept, {"--spacing"})
        kept = _without(kept, {"--max-points"}, "1")  # a fit has more
    options = [word for option in fly_all for word in option.split()]
    return shlex.join(["flight-replay", *repeat_arguments([*kept, *options, *arguments[end:]])])


def _without(arguments: Sequence[str], options: Set[str], value: str | None = None) -> list[str]:
    """The arguments without some options that have a value, or only without those of one value."""
    kept: list[str] = []
    rest = iter(arguments)
    for argument in rest:
        option, equals, given = argument.partition("=")
        if option not in options:
            kept.append(argument)
            continue
        words = [argument] if equals else [argument, *islice(rest, 1)]
        if value not in (None, given if equals else words[-1]):
            kept += words
    return kept


def _end_of_options(arguments: Sequence[str]) -> int:
    """How many arguments there are before those that are no options whatever they begin with."""
    return arguments.index("--") if "--" in arguments else len(arguments)
