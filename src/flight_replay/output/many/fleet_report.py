"""The report of many flights: one self-contained HTML file with a table, a map and histograms."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from html import unescape
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flight_replay.exceptions import FlightReplayError
from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.geodesy import EQUATORIAL_RADIUS_M
from flight_replay.output.many.fleet_summary import FleetSummary, summary_lines
from flight_replay.output.many.flight_columns import COLUMN_OF, ERRORS, GOOD, Row, error_column
from flight_replay.writing.counted import counted
from flight_replay.writing.output_files import check_place, check_suffix, write_atomically

if TYPE_CHECKING:
    from bokeh.model import Model
    from bokeh.models import ColumnDataSource
    from bokeh.models.ui import UIElement

SUFFIXES = (".html", ".htm")
_BINS = 30
_LARGEST_SHARE = 0.98
_HISTOGRAM_WIDTH, _HISTOGRAM_HEIGHT = 350, 240
_GOOD_COLOUR, _BAD_COLOUR = "#1f77b4", "#d62728"
_MAX_LAT_DEG = 85.0
_SHOWN = (
    "log", "flight", "status", "problem", "vehicle_type", "duration_s", "length_m", "fixes", "rejected",
    "waypoints", "predicted_duration_s", "flown_by", "ended", "waypoints_reached", "doubts",
)  # fmt: skip
_HIDDEN = ("command", "start_lat_deg", "start_lon_deg")
_MEANS = tuple(error_column(prefix, error, "mean") for prefix in ("predicted", "flown") for error in ERRORS)
_DISTRIBUTED = ("duration_s", "length_m", "highest_m", "top_speed_m_s", *_MEANS)
_WIDTHS = {"log": 260, "problem": 260, "doubts": 200, "ended": 130, "status": 90, "vehicle_type": 110}


def check_report_name(path: Path, command: str, *, replace: bool) -> None:
    """Refuse a name that the report of ``command`` cannot be written to.

    Raises:
        FlightReplayError: The suffix is another, it is a folder or cannot be written in its folder, or a
            file is there that is not to be replaced, nor the report of the same command.
    """
    check_suffix(path, SUFFIXES)
    check_place(path)
    if path.expanduser().is_file() and not replace and not _is_report_of(path.expanduser(), command):
        raise FlightReplayError(f"{path} exists; choose another name, or replace it with --force")


def _is_report_of(path: Path, command: str) -> bool:
    """Whether a file is the report of a command: the same command goes on where it was stopped."""
    try:
        return f"<pre>{command}</pre>" in unescape(path.read_text(encoding="utf-8", errors="replace"))
    except OSError:
        return False


def save_fleet_report(path: Path, rows: Iterable[Row], command: str) -> None:
    """Write the report of some rows, which are read once; ``command`` is what made them.

    Raises:
        FlightReplayError: The file cannot be written.
    """
    from bokeh.embed import file_html
    from bokeh.resources import Resources
    from jinja2 import Template

    summary, columns = FleetSummary(), _Columns()
    for row in rows:
        summary.add(row)
        columns.add(row)
    template = files("flight_replay.output.many").joinpath("fleet_report.html").read_text(encoding="utf-8")
    roots = _roots(columns)
    page = file_html(
        roots,
        resources=Resources(mode="inline"),
        title="Replays of many flights",
        template=Template(template),
        template_variables={
            "lead": _lead(summary),
            "summary": "\n".join(summary_lines(summary)),
            "has_map": any(root.name == "map" for root in roots),
            "has_histograms": any(root.name == "histograms" for root in roots),
            "command": command,
            "made_by": f"Made by flight-replay {version('flight-replay')}.",
        },
    )
    write_atomically(path, page)


def _lead(summary: FleetSummary) -> str:
    return f"{counted(summary.rows, 'row')}, {summary.failed} of them without a flight that went as asked."


class _Columns:
    """What the page shows of each row, by column."""

    def __init__(self) -> None:
        self.values: dict[str, list[Any]] = {name: [] for name in (*_SHOWN, *_HIDDEN, *_DISTRIBUTED)}

    def add(self, row: Row) -> None:
        for name, values in self.values.items():
            values.append(row.get(name))

    def numbers(self, name: str) -> Floats:
        """The values of a column that are known."""
        return np.array([value for value in self.values[name] if value is not None], float)

    def shown(self) -> dict[str, Sequence[Any]]:
        """The columns that hold anything; unknown numbers are no numbers."""
        return {
            name: [_unknown(name) if value is None else value for value in values]
            for name, values in self.values.items()
            if any(value is not None for value in values)
        }


def _unknown(name: str) -> Any:
    return "" if COLUMN_OF[name].kind == "text" else math.nan


def _roots(columns: _Columns) -> list[Model]:
    """What the template shows, by name: table and command; map and histograms where there is anything."""
    from bokeh.layouts import row
    from bokeh.models import ColumnDataSource, CustomJS
    from bokeh.models.widgets import PreText

    data = columns.shown()
    source = ColumnDataSource({**data, **_map_columns(columns)})
    command = PreText(
        text="click a row: here is the command that repeats it",
        name="command",
        sizing_mode="stretch_width",
        styles={"white-space": "pre-wrap", "overflow-wrap": "anywhere"},
    )
    if "command" in data:
        code = """
            const rows = source.selected.indices;
            if (rows.length > 0) { command.text = rows.map((row) => source.data.command[row]).join("\\n"); }
        """
        source.selected.js_on_change(
            "indices", CustomJS(args={"source": source, "command": command}, code=code)
        )
    roots: list[Model] = [_table(source, data), command]
    if "start_lat_deg" in data:
        roots.append(_map(source))
    histograms: list[Any] = [_histogram(name, columns.numbers(name)) for name in _DISTRIBUTED if name in data]
    if histograms:
        wrapped = row(histograms, sizing_mode="stretch_width", styles={"flex-wrap": "wrap"})
        wrapped.name = "histograms"
        roots.append(wrapped)
    return roots


def _table(source: ColumnDataSource, data: dict[str, Sequence[Any]]) -> UIElement:
    from bokeh.models.widgets import DataTable, HTMLTemplateFormatter, NumberFormatter, TableColumn

    # Texts of logs may hold markup: the formatter's <%- escapes them.
    text = HTMLTemplateFormatter(template="<%- value %>")
    whole, number = NumberFormatter(format="0", nan_format=""), NumberFormatter(format="0.00", nan_format="")
    formats: dict[str, Any] = {"text": text, "whole": whole, "number": number, "truth": text}
    shown = [
        TableColumn(
            field=name,
            title=name.replace("_", " "),
            formatter=formats[COLUMN_OF[name].kind],
            width=_WIDTHS.get(name, 100),
        )
        for name in (*_SHOWN, *_MEANS)
        if name in data
    ]
    return DataTable(
        source=source,
        columns=shown,
        sortable=True,
        reorderable=True,
        autosize_mode="none",
        height=520,
        sizing_mode="stretch_width",
        name="table",
    )


def _map_columns(columns: _Columns) -> dict[str, Any]:
    """Where each flight began, metres of the Mercator projection, and the colour of its dot."""
    lat, lon = (
        np.array([math.nan if value is None else value for value in columns.values[name]], float)
        for name in ("start_lat_deg", "start_lon_deg")
    )
    north = np.arctanh(np.sin(np.radians(np.clip(lat, -_MAX_LAT_DEG, _MAX_LAT_DEG))))
    good = [status in GOOD for status in columns.values["status"]]
    return {
        "mercator_x": np.radians(lon) * EQUATORIAL_RADIUS_M,
        "mercator_y": north * EQUATORIAL_RADIUS_M,
        "colour": [_GOOD_COLOUR if each else _BAD_COLOUR for each in good],
        "place": [f"{each[0]:.5f}, {each[1]:.5f}" for each in zip(lat, lon, strict=True)],
    }


def _map(source: ColumnDataSource) -> UIElement:
    from bokeh.models import HoverTool
    from bokeh.plotting import figure

    chart = figure(
        x_axis_type="mercator",
        y_axis_type="mercator",
        x_axis_label="longitude",
        y_axis_label="latitude",
        match_aspect=True,
        tools="pan,wheel_zoom,box_zoom,tap,reset,save",
        active_scroll="wheel_zoom",
        height=520,
        sizing_mode="stretch_width",
        name="map",
    )
    chart.toolbar.logo = None
    chart.scatter(
        "mercator_x", "mercator_y", source=source, size=8, color="colour", alpha=0.5, line_color=None
    )
    shown = [("log", "@log"), ("place", "@place"), ("status", "@status")]
    chart.add_tools(HoverTool(tooltips=shown))
    return chart


def _histogram(name: str, values: Floats) -> UIElement:
    """How many flights have which value of a column; the largest few are in the last bar."""
    from bokeh.models.annotations import Title
    from bokeh.plotting import figure

    top = float(np.quantile(values, _LARGEST_SHARE))
    low = float(values.min())
    top = top if top > low else low + 1.0
    counts, edges = np.histogram(np.minimum(values, top), bins=_BINS, range=(low, top))
    chart = figure(
        title=Title(text=name.replace("_", " "), text_font_size="9pt"),
        x_axis_label=f"median {np.median(values):.2f}",
        width=_HISTOGRAM_WIDTH,
        height=_HISTOGRAM_HEIGHT,
        tools="",
        toolbar_location=None,
        y_axis_label="flights",
    )
    chart.toolbar.logo = None
    chart.quad(
        top=counts.astype(float),
        bottom=0,
        left=edges[:-1],
        right=edges[1:],
        color=_GOOD_COLOUR,
        line_color="white",
    )
    return chart
