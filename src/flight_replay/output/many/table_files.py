"""Tables of flights as Parquet or CSV: read and written some rows at a time, replaced whole or not at all."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from flight_replay.exceptions import FlightReplayError
from flight_replay.output.many.flight_columns import COLUMN_OF, COLUMNS, Kind, Row
from flight_replay.writing.output_files import NewFile, cannot_write, check_place, check_suffix

if TYPE_CHECKING:
    import pyarrow

SUFFIXES = (".parquet", ".csv")
_ROWS_AT_ONCE = 2_000
_TRUTH = {"true": True, "false": False}


def check_table_name(path: Path) -> None:
    """Refuse a name that no table can be written to.

    Raises:
        FlightReplayError: The suffix is another, it is a folder or cannot be written in its folder, or
            pyarrow is missing.
    """
    suffix = check_suffix(path, SUFFIXES)
    check_place(path)
    if suffix == ".parquet":
        _pyarrow()


def rows_of(path: Path) -> Iterator[Row]:
    """The rows of a table, read some at a time; columns that this version does not know are left out.

    Raises:
        FlightReplayError: It does not exist, or is no such table.
    """
    suffix = check_suffix(path, SUFFIXES)
    try:
        yield from (_parquet_rows if suffix == ".parquet" else _csv_rows)(path.expanduser())
    except FileNotFoundError:
        raise FlightReplayError(f"{path} does not exist; name a table of flights") from None
    except (OSError, ValueError, csv.Error) as error:
        raise FlightReplayError(f"cannot read {path}: {error}; is it a table of flights?") from error


def write_rows(path: Path, rows: Iterable[Row]) -> None:
    """Replace the table at ``path`` with these rows once all of them are on disk.

    Raises:
        FlightReplayError: It cannot be written.
    """
    write = _write_parquet if check_suffix(path, SUFFIXES) == ".parquet" else _write_csv
    new = NewFile(path)
    try:
        write(new.file, _batches(rows))
        new.file.flush()
        os.fsync(new.file.fileno())
        new.put_in_place()
    except OSError as error:
        new.discard()
        raise cannot_write(path, error) from error
    except BaseException:
        new.discard()
        raise


def _batches(rows: Iterable[Row]) -> Iterator[list[Row]]:
    left = iter(rows)
    while batch := list(islice(left, _ROWS_AT_ONCE)):
        yield batch


def _pyarrow() -> None:
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError as error:
        raise FlightReplayError(
            'Parquet needs pyarrow; install it with: pip install "flight-replay[many]", or name a .csv file'
        ) from error


def _schema() -> pyarrow.Schema:
    import pyarrow

    types: dict[Kind, pyarrow.DataType] = {
        "text": pyarrow.string(),
        "whole": pyarrow.int64(),
        "number": pyarrow.float64(),
        "truth": pyarrow.bool_(),
    }
    return pyarrow.schema([(column.name, types[column.kind]) for column in COLUMNS])


def _parquet_rows(path: Path) -> Iterator[Row]:
    _pyarrow()
    import pyarrow
    import pyarrow.parquet

    with path.open("rb") as file:
        try:
            table = pyarrow.parquet.ParquetFile(file)
        except pyarrow.ArrowException as error:
            raise ValueError(str(error).splitlines()[0]) from error
        names = [name for name in table.schema_arrow.names if name in COLUMN_OF]
        for batch in table.iter_batches(batch_size=_ROWS_AT_ONCE, columns=names):
            for row in batch.to_pylist():
                yield {name: value for name, value in row.items() if value is not None}


def _write_parquet(file: BinaryIO, batches: Iterator[Sequence[Row]]) -> None:
    import pyarrow
    import pyarrow.parquet

    schema = _schema()
    with pyarrow.parquet.ParquetWriter(file, schema) as writer:
        for batch in batches:
            writer.write_table(pyarrow.Table.from_pylist([dict(row) for row in batch], schema=schema))


def _csv_rows(path: Path) -> Iterator[Row]:
    with path.open(encoding="utf-8", newline="") as file:
        table = csv.DictReader(file)
        if "log" not in (table.fieldnames or ()):
            raise ValueError('it has no column "log"')
        for texts in table:
            yield {
                name: _value(COLUMN_OF[name].kind, text)
                for name, text in texts.items()
                if text and name in COLUMN_OF
            }


def _value(kind: Kind, text: str) -> Any:
    if kind == "text":
        return text
    if kind == "truth":
        if text.lower() not in _TRUTH:  # Spreadsheets save capitals.
            raise ValueError(f"{text!r} is neither true nor false")
        return _TRUTH[text.lower()]
    return int(text) if kind == "whole" else float(text)


def _write_csv(file: BinaryIO, batches: Iterator[Sequence[Row]]) -> None:
    text = io.TextIOWrapper(file, encoding="utf-8", newline="")
    try:
        writer = csv.DictWriter(text, [column.name for column in COLUMNS], lineterminator="\n")
        writer.writeheader()
        for batch in batches:
            for row in batch:
                writer.writerow({name: _text(value) for name, value in row.items()})
    finally:
        text.detach()  # flushes, and leaves the file open


def _text(value: Any) -> Any:
    return str(value).lower() if isinstance(value, bool) else value
