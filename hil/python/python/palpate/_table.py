"""Tables: numpy's structured arrays that pandas, polars and Arrow take as they are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from . import _palpate

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas
    import polars



class Table(np.ndarray[Any, np.dtype[Any]]):
    """A structured array: ``table["x_mm"]`` is a column, ``table[0]`` a row, ``table[table["level"] > 3]`` a table.

    Tables of results cannot be written to; ``table.copy()`` can.
    """

    def __getitem__(self, key: Any) -> Any:
        found = super().__getitem__(key)
        if isinstance(found, Table) and found.dtype.names is None:
            return found.view(np.ndarray)
        return found

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of the columns."""
        return self.dtype.names or ()

    def to_pandas(self) -> pandas.DataFrame:
        """As a data frame of pandas, which has to be installed."""
        import pandas

        frame: pandas.DataFrame = pandas.DataFrame(
            {name: np.asarray(self[name]) for name in self.columns}
        )
        return frame

    def to_polars(self) -> polars.DataFrame:
        """As a data frame of polars, which has to be installed."""
        import polars

        return polars.DataFrame({name: np.asarray(self[name]) for name in self.columns})

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """As a stream of Arrow's, by its C interface: ``pyarrow.table(t)``, ``duckdb.sql("from t")``."""
        rows = np.atleast_1d(self)
        columns: list[tuple[str, str, bytes | list[str]]] = []
        for name in self.columns:
            values = np.asarray(rows[name])
            if values.dtype.kind == "U":
                columns.append((name, "words", values.tolist()))
            else:
                columns.append((name, values.dtype.str, values.tobytes()))
        return _palpate.arrow_stream(columns)


def table(columns: Sequence[tuple[str, str | None, bytes | list[str]]]) -> Table:
    """A table of columns as ``_palpate`` hands them out."""
    fields: list[tuple[str, str]] = []
    values: list[Any] = []
    for name, kind, data in columns:
        if kind is None:
            longest = max(map(len, data), default=0)  # type: ignore[arg-type]
            kind = f"<U{max(longest, 1)}"
            values.append(data)
        else:
            values.append(np.frombuffer(data, kind))  # type: ignore[arg-type]
        fields.append((name, kind))
    made = np.empty(len(values[0]) if values else 0, np.dtype(fields))
    for (name, _), column in zip(fields, values, strict=True):
        made[name] = column
    made.flags.writeable = False
    return made.view(Table)
