"""The results of a replay as lines for people, which fit a terminal of 80 columns."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flight_replay.geometry.error_statistics import ErrorStatistics
from flight_replay.writing.counted import counted, counted_of

if TYPE_CHECKING:
    from flight_replay.geometry.flight_errors import FlightErrors, PathErrors
    from flight_replay.output.outcome import Coverage, Outcome
    from flight_replay.planning.route import Route


_WORTH_TELLING_S = 0.05


def route_lines(route: Route) -> list[str]:
    """The route: what it covers, and how near it is to the recording as planned and as predicted."""
    covered = counted_of(len(route.recorded), len(route.recording), "fix")
    lines = [
        f" Route: {route.path.length_m:.0f} m, covers {covered}",
        *path_lines("Planned path error", route.planned_error, "planned"),
    ]
    if route.predicted is not None:
        lines.append(f" Predicted duration: {route.predicted_duration_s:.0f} s")
        lines += error_lines("Predicted ", route.predicted)
    return lines


def flight_lines(route: Route, outcome: Outcome, fly_all_command: str | None = None) -> list[str]:
    """The flight: its errors, what it covered, and at the end the command that flies all of the recording."""
    return [
        *error_lines("", outcome.errors),
        *alignment_lines(outcome),
        _reached_line(route, outcome),
        *coverage_lines(outcome.coverage, fly_all_command if outcome.record.problem is None else None),
    ]


def _reached_line(route: Route, outcome: Outcome) -> str:
    record = outcome.record
    if route.reference is not None:
        followed_s = outcome.coverage.recorded_s
        return f" Followed {followed_s:.1f} s of the recording in {record.auto_s:.1f} s of GUIDED"
    reached = counted_of(record.waypoints_reached, len(route.mission.waypoints), "waypoint")
    return f" Reached {reached} in {record.auto_s:.1f} s of AUTO"


def coverage_lines(coverage: Coverage, fly_all_command: str | None = None) -> list[str]:
    """Which part of what was to be replayed was flown again, and how all of it is."""
    lines = [f" Flown: {coverage_text(coverage)}"]
    if coverage.fly_all and fly_all_command is not None:
        lines.append(f" To fly all of it: {fly_all_command}")
    return lines


def coverage_text(coverage: Coverage) -> str:
    """The part that was flown again, such as "the first 46 s of 3 min 2 s of recorded flight".

    The whole is what was selected of the recording, whose flights may be longer.
    """
    if not coverage.timed:
        fixes = coverage.fixes if coverage.fly_all else coverage.of_fixes
        told = counted_of(fixes, coverage.of_fixes, "recorded fix")
        return f"the first {told}" if fixes < coverage.of_fixes else told
    part, whole = duration_text(coverage.recorded_s), duration_text(coverage.of_recorded_s)
    which = f"the first {part} of {whole}" if coverage.fly_all else f"all {whole}"
    return f"{which} of recorded flight"


def duration_text(seconds: float) -> str:
    """A duration in minutes and seconds, such as "4 min 12 s"."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"


def error_lines(prefix: str, errors: FlightErrors) -> list[str]:
    """All errors of a flight; those at equal times that do not exist are left out, but for the position's."""
    name = f"{prefix}path error" if prefix else "Path error"
    lines = path_lines(name, errors.path_m, "flown")
    for kind, error, unit in (
        ("position", errors.position_m, "m"),
        ("height", errors.height_m, "m"),
        ("heading", errors.heading_deg, "deg"),
    ):
        title = f"{prefix}{kind} error" if prefix else f"{kind.capitalize()} error"
        if len(error) or kind == "position":
            lines.append(f" {title}: {statistics_text(error.statistics, unit)}")
    return lines


def path_lines(name: str, errors: PathErrors, path: str) -> list[str]:
    """The path error both ways, a line each."""
    return [
        f" {name}, recorded to {path}: {statistics_text(errors.recorded_to_path.statistics)}",
        f" {name}, {path} to recorded: {statistics_text(errors.path_to_recorded.statistics)}",
    ]


def alignment_lines(outcome: Outcome) -> list[str]:
    """What the errors at equal times put on what, and how long the recording waited for the vehicle."""
    position, waited_s = outcome.errors.position_m, outcome.waited_s
    what = "the first flown fix at waypoint 1" if waited_s is None else "by the recording's clock"
    if not len(position):
        return []
    seconds = position.time_s[-1] - position.time_s[0]
    lines = [f" At equal times: {what}, {counted(len(position), 'fix')}, {seconds:.0f} s"]
    if waited_s is not None and waited_s >= _WORTH_TELLING_S:
        lines.append(f" The recording waited {waited_s:.1f} s for the vehicle")
    return lines


def statistics_text(error: ErrorStatistics | None, unit: str = "m") -> str:
    """Mean, 95th percentile and maximum: metres to the centimetre, degrees to the tenth."""
    if error is None:
        return "nothing to compare"
    digits = 2 if unit == "m" else 1
    return ", ".join(
        f"{name} {value:.{digits}f} {unit}"
        for name, value in (("mean", error.mean), ("p95", error.p95), ("max", error.max))
    )
