"""The command that flies all of the recorded flight, out of the one that flew a part of it."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

_WRITES = ("--save", "--record", "--plot", "--report")


def whole_flight_command(arguments: Sequence[str], fly_all: Sequence[str]) -> str:
    """The command line of a run, with the options that fly all of the recording.

    The files that the run wrote are replaced by those of the whole flight.

    Args:
        arguments: Those of the run, without the program's name.
        fly_all: Options with their values, such as "--duration all"; they take the place of those given.
    """
    end = arguments.index("--") if "--" in arguments else len(arguments)
    replaced = {option.split()[0] for option in fly_all}
    if "--route" in replaced:
        replaced.add("--spacing")
    kept: list[str] = []
    rest = iter(arguments[:end])
    for argument in rest:
        if argument in replaced:
            next(rest, None)
        elif argument.split("=")[0] not in replaced:
            kept.append(argument)
    options = [word for option in fly_all for word in option.split()]
    if "--force" not in kept and any(argument.split("=")[0] in _WRITES for argument in kept):
        options.append("--force")
    return shlex.join(["flight-replay", *kept, *options, *arguments[end:]])
