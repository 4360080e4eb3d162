"""What a replay leaves behind: words, the JSON object, the mission, pictures and the report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from flight_replay.cli.options import Options
from flight_replay.errors import FlightReplayError
from flight_replay.output import json_summary as contract
from flight_replay.output_files import check_suffix

if TYPE_CHECKING:
    from flight_replay.cli.flight_step import Flown
    from flight_replay.geometry.distances import ErrorStatistics
    from flight_replay.logs.flights import Flight
    from flight_replay.logs.tlog import Log
    from flight_replay.output.event_log import LoggedEvent
    from flight_replay.planning.route import Route


@dataclass(frozen=True, slots=True, eq=False)
class Replay:
    """Everything there is to tell of a run; ``flown`` is None when nothing was flown."""

    log: Log
    flights: tuple[Flight, ...]
    route: Route
    flown: Flown | None


def check_outputs(options: Options) -> None:
    """Refuse output files and ground stations that cannot work, before anything is read or flown.

    Raises:
        FlightReplayError: A file has an unknown suffix or its folder does not exist, or a ground
            station's connection string is not valid.
    """
    _check_suffixes(options)
    for file in (*options.save, options.plot, options.report, options.record):
        if file and not file.expanduser().parent.is_dir():
            raise FlightReplayError(f"cannot write {file}: no folder {file.parent}; create it first")
    if options.gcs:
        from flight_replay.vehicle.link.ground_station_sockets import socket_for

        for station in options.gcs:
            socket_for(station)


def _check_suffixes(options: Options) -> None:
    if options.save:
        from flight_replay.mission import formats

        for path in options.save:
            check_suffix(path, formats.SAVED_SUFFIXES)
    if options.plot:
        from flight_replay.output.charts import plot

        check_suffix(options.plot, plot.SUFFIXES)
    if options.report:
        from flight_replay.output.charts import report

        check_suffix(options.report, report.SUFFIXES)


def save_mission(options: Options, route: Route) -> None:
    """Write the mission, and the recorded track where the format holds one."""
    if options.save:
        from flight_replay.mission import formats

        for path in options.save:
            formats.save(path, route.mission, route.covered)


def save_pictures(
    options: Options, result: Replay, events: Sequence[LoggedEvent], arguments: Sequence[str]
) -> None:
    """Draw and report the replay."""
    record, outcome = (result.flown.record, result.flown.outcome) if result.flown else (None, None)
    if options.plot:
        from flight_replay.output.charts.plot import save_plot

        save_plot(options.plot, result.route, record, outcome)
    if options.report:
        from flight_replay.output.charts.report import ReportText, save_report

        text = ReportText(summary(result), events, arguments)
        save_report(options.report, text, result.route, record, outcome)


def summary(result: Replay) -> dict[str, Any]:
    """The ``--json`` object."""
    flown = result.flown
    return {
        "log": contract.log_summary(result.log, result.flights),
        "route": contract.route_summary(result.route),
        "flight": flown
        and contract.flight_summary(flown.vehicle, flown.simulated, flown.record, flown.outcome),
    }


def words(result: Replay) -> list[str]:
    """The result for people, a line each."""
    route = result.route
    lines = [
        f" The route is {route.path.length_m:.0f} m long and covers {len(route.covered)} of "
        f"{len(result.log.track)} fixes; planned error: {_metres(route.planned_error)}"
    ]
    if route.predicted:
        lines.append(
            f" Predicted: {route.predicted_duration_s:.0f} s; "
            f"in space {_metres(route.predicted.path_error)}; "
            f"in time {_metres(route.predicted.position_error)}"
        )
    if result.flown:
        record, outcome = result.flown.record, result.flown.outcome
        lines += [
            f" Reached {record.waypoints_reached} of {len(route.mission.waypoints)} waypoints "
            f"in {record.auto_s:.1f} s of AUTO",
            f" Distance from the recorded flight in space: {_metres(outcome.path_error)}",
            f" Distance from the recorded flight in time: {_metres(outcome.position_error)}",
        ]
    return lines


def _metres(spread: ErrorStatistics | None) -> str:
    if spread is None:
        return "nothing to compare"
    return f"mean {spread.mean:.2f} m, p95 {spread.p95:.2f} m, max {spread.max:.2f} m"
