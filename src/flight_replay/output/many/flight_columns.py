"""The columns of the table of flights, the same for every row: docs/many.md lists them.

Lengths in metres, times in seconds, speeds in m/s, angles in degrees; the name says which.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

Row = Mapping[str, Any]
"""One flight: values by column name; what is unknown, or was not asked for, is left out."""

Kind = Literal["text", "whole", "number", "truth"]

STATISTICS = {"mean": "mean", "p95": "95th percentile", "max": "maximum"}
"""The statistics of an error, by their part of the columns' names."""
ERRORS = {
    "path_recorded_to_{path}": ("m", "path error from the recorded fixes to the {path} path"),
    "path_{path}_to_recorded": ("m", "path error from the {path} path to the recorded line"),
    "position": ("m", "position error at equal times"),
    "height": ("m", "height error at equal times"),
    "heading": ("deg", "heading error at equal times"),
}
"""Units and meaning of the errors of a flight, by their part of the columns' names."""


@dataclass(frozen=True, slots=True)
class TableColumn:
    """A column: what kind of values it has, and what they mean."""

    name: str
    kind: Kind
    meaning: str


def error_column(prefix: str, error: str, statistic: str) -> str:
    """The name of the column of an error's statistic, such as "flown_position_mean_m"."""
    unit, _ = ERRORS[error]
    path = "planned" if prefix == "planned" else "flown"
    return f"{prefix}_{error.format(path=path)}_{statistic}_{unit}"


def _error_columns(prefix: str, errors: tuple[str, ...]) -> Iterator[TableColumn]:
    path = "planned" if prefix == "planned" else "flown"
    for error in errors:
        for statistic, word in STATISTICS.items():
            meaning = ERRORS[error][1].format(path=path)
            yield TableColumn(error_column(prefix, error, statistic), "number", f"{meaning}, {word}")


BOTH_WAYS = tuple(ERRORS)[:2]
"""The errors that a path on paper has."""

COLUMNS: tuple[TableColumn, ...] = (
    TableColumn("log", "text", "path of the log, as it was found"),
    TableColumn("log_sha256", "text", "hash of the log's bytes; none where it could not be read"),
    TableColumn("log_bytes", "whole", "size of the file"),
    TableColumn("log_modified_ns", "whole", "when the file was changed last, Unix time in nanoseconds"),
    TableColumn("log_rows", "whole", "how many rows this log has"),
    TableColumn("copy_of", "text", "the log of the same content that was flown in this one's place"),
    TableColumn("log_format", "text", "format, as `--json` names it"),
    TableColumn("vehicle_system", "whole", "MAVLink system id, where the log has one"),
    TableColumn("vehicle_component", "whole", "MAVLink component id, where the log has one"),
    TableColumn("vehicle_type", "text", "kind of vehicle, such as quadcopter"),
    TableColumn("is_multicopter", "truth", "whether that is a multicopter"),
    TableColumn("recorded_firmware", "text", "firmware that the log names"),
    TableColumn("flight", "whole", "number of the flight in its log, from 1; none where there is no flight"),
    TableColumn("flights", "whole", "how many flights of this vehicle the log has"),
    TableColumn("status", "text", "what became of it, see above"),
    TableColumn("problem", "text", "why it is not planned, or not flown as asked: one line"),
    TableColumn(
        "fit_for_replay", "truth", "a plan exists, and nothing speaks against a multicopter's flight"
    ),
    TableColumn("doubts", "text", "what speaks against that"),
    TableColumn("start_utc_s", "number", "when the flight began, Unix time, where the log knows"),
    TableColumn("start_s", "number", "when it began, from the log's first fix"),
    TableColumn("duration_s", "number", "how long the recorded flight was"),
    TableColumn("start_lat_deg", "number", "latitude where it began"),
    TableColumn("start_lon_deg", "number", "longitude where it began"),
    TableColumn("end_lat_deg", "number", "latitude where it ended"),
    TableColumn("end_lon_deg", "number", "longitude where it ended"),
    TableColumn("length_m", "number", "distance over ground along its fixes"),
    TableColumn("highest_m", "number", "greatest height above home"),
    TableColumn("top_speed_m_s", "number", "greatest speed over ground"),
    TableColumn("fixes", "whole", "fixes of the flight"),
    TableColumn("log_fixes", "whole", "usable fixes of this vehicle in the log"),
    TableColumn("without_position", "whole", "records of the log at latitude and longitude 0"),
    TableColumn("rejected", "whole", "implausible positions of the log that were left out"),
    TableColumn("rejected_by_reason", "text", "the same by reason, as a JSON object"),
    TableColumn("notes", "text", "what `flight-replay` says of the log and the plan"),
    TableColumn("method", "text", "how it was planned: spacing, fit or guided"),
    TableColumn("waypoints", "whole", "waypoints of the mission; 0 in GUIDED"),
    TableColumn("fixes_covered", "whole", "flown fixes that the plan covers"),
    TableColumn("planned_length_m", "number", "length of the planned path"),
    *_error_columns("planned", BOTH_WAYS),
    TableColumn("predicted_duration_s", "number", "time in AUTO, or of following, that the model predicts"),
    *_error_columns("predicted", tuple(ERRORS)),
    TableColumn("flown_by", "text", "what flew it: model, builtin or sitl; none where nothing did"),
    TableColumn("flown_vehicle", "text", "firmware, version and kind of the vehicle that flew it"),
    TableColumn("waypoints_reached", "whole", "waypoints that it reached"),
    TableColumn("ended", "text", "how the replay ended, as in `--json`"),
    TableColumn("rtl_confirmed", "truth", "whether the vehicle confirmed RTL"),
    TableColumn("auto_s", "number", "time in AUTO, or of following, by the vehicle's clock"),
    TableColumn("fixes_flown", "whole", "fixes of the recording that were flown again"),
    *_error_columns("flown", tuple(ERRORS)),
    TableColumn("plan_wall_s", "number", "time that reading and planning took"),
    TableColumn("fly_wall_s", "number", "time that the replay took, by the wall clock"),
    TableColumn("worker", "text", "machine that did it, if known"),
    TableColumn("options", "text", "the options it was done with"),
    TableColumn("options_id", "text", "hash of the options, and of the SITL binary"),
    TableColumn("version", "text", "version of flight-replay"),
    TableColumn(
        "command",
        "text",
        "the command that repeats it, for one flight: the flight on a simulator, else its plan",
    ),
)
COLUMN_OF = {column.name: column for column in COLUMNS}


class Status:
    """The values of the column ``status``."""

    PLANNED = "planned"
    FLOWN = "flown"
    NO_FLIGHT = "no flight"
    UNREADABLE = "unreadable"
    REFUSED = "refused"
    FAILED = "failed"
    WORKER_LOST = "worker lost"
    INTERNAL_ERROR = "internal error"


GOOD = (Status.PLANNED, Status.FLOWN)
"""The statuses of flights that went as asked."""
