"""``--compare``: a replay, or any recording, measured against another one."""

from __future__ import annotations

import json
import sys

from flight_replay.cli.options import Options
from flight_replay.flight_modes import CopterMode
from flight_replay.logs.flights import select
from flight_replay.logs.read_log import read_log
from flight_replay.output.comparison import Comparison, compare_tracks, part_in
from flight_replay.output.console.console import Console
from flight_replay.output.console.terminal import write_verbatim
from flight_replay.output.json_summary import errors_summary
from flight_replay.output.result_text import error_lines
from flight_replay.writing.counted import counted


def compare(options: Options, console: Console) -> None:
    """Write the errors of the second log of ``--compare`` against the first.

    Raises:
        LogError: One of them cannot be read, or does not move.
    """
    paths = options.compare or ()
    recordings = [read_log(path) for path in paths]
    # A recording may have been flown in GUIDED by hand; a replay is in AUTO, or follows in GUIDED.
    first, first_part = part_in(recordings[0], [CopterMode.AUTO])
    second, second_part = part_in(recordings[1], [CopterMode.AUTO, CopterMode.GUIDED])
    if options.flight is not None:
        first, first_part = select(recordings[0].track, options.flight), f"flight {options.flight}"
    result = compare_tracks(first, second, options.from_s, options.to_s)
    if options.json:
        write_verbatim(sys.stdout, json.dumps({"compared": _summary(paths, result)}))
        return
    console.print(f"{paths[1]} ({second_part}) against {paths[0]} ({first_part}):")
    for line in error_lines("", result.errors):
        console.print(line)
    console.print(
        f" At equal times: from the first of {counted(result.fixes, 'fix')} that both have, "
        f"{len(result.errors.position_m)} of them"
    )


def _summary(paths: tuple[str, ...], result: Comparison) -> dict[str, object]:
    return {"paths": list(paths), "fixes": result.fixes, **errors_summary(result.errors)}
