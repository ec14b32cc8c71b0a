"""Files as arrays and tables."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _palpate
from ._errors import InputError
from ._setup import Name
from ._table import Table, table


@dataclass(frozen=True)
class Recording:
    """Recorded taxels of one module.

    Attributes:
        time_us: Time of each row, microseconds, shape (rows,).
        counts: Raw counts, shape (rows, taxels, axes).
        notes: Remarks on the file, for example that it is truncated.
    """

    time_us: npt.NDArray[np.uint64]
    counts: npt.NDArray[np.uint16]
    notes: tuple[str, ...] = ()


def load(
    path: Name | Sequence[Name], layout: Name | None = None, *, rate_hz: float | None = None
) -> Recording | list[Recording] | Table:
    """Reads a file, and finds its format from its content.

    Args:
        path: Taxels (CSV or .npy; with a layout), frames of buses (candump log or MCAP), a schedule (JSON Lines), or
            contacts (CSV). For a skin with several modules, a list of files, one per module.
        layout: The skin of taxels or buses, a name or a file. Frames come no faster than its ``bitrate`` allows, 1 Mbit/s
            without a layout.
        rate_hz: Rows per second of taxels without times.

    Returns:
        Taxels give a :class:`Recording`, several files a list of them. Buses give a table time_us, bus, id, data
        (hexadecimal); ``palpate.run(replay=path, layout=..).taxels`` has their readings. A schedule gives a table like
        ``Run.stimuli``, contacts one like ``Run.contacts``, with a column for the display if there are several.
    """
    several = not isinstance(path, str | os.PathLike)
    paths = [os.fspath(one) for one in path] if not isinstance(path, str | os.PathLike) else [os.fspath(path)]
    for one in paths:
        if not os.path.exists(one):
            raise InputError.of(one, "a file", "nothing", "look at the path")
    found = _palpate.kind(paths[0]) if paths else None
    if found == "taxels":
        if layout is None:
            raise InputError.of("layout", "the skin of the taxels", "none", 'such as layout="uskin-4x4"')
        modules, axes, notes = _palpate.load_taxels(paths, os.fspath(layout), rate_hz)
        recordings = []
        for times, counts in modules:
            time_us = np.frombuffer(times, "<u8")
            rows = np.frombuffer(counts, "<u2").reshape(len(time_us), -1, axes)
            recordings.append(Recording(time_us, rows, tuple(notes)))
        return recordings if several else recordings[0]
    if several:
        raise InputError.of("path", "one file, or taxels", f"{len(paths)} files")
    if found == "buses":
        return table(_palpate.load_buses(paths[0], None if layout is None else os.fspath(layout))[0])
    if found == "schedule":
        return table(_palpate.load_schedule(paths[0])[0])
    if found == "contacts":
        return _contacts(paths[0])
    expected = "taxels (CSV, .npy), frames of buses (candump, MCAP), a schedule (JSON Lines) or contacts (CSV)"
    raise InputError.of(paths[0] if paths else "path", expected, "something else")


_CONTACTS = (
    ("frame", "<u4"),
    ("time_us", "<u8"),
    ("module", "<u2"),
    ("contact", "<u4"),
    ("x_mm", "<f8"),
    ("y_mm", "<f8"),
    ("intensity", "<f8"),
    ("level", "<u2"),
    ("members", "<u4"),
)


def _contacts(path: str) -> Table:
    with open(path, encoding="utf-8") as file:
        columns = file.readline().strip().split(",")
    # Tables of several displays say the display of each contact.
    fields = [*_CONTACTS, ("display", "<U64")][: len(columns)]
    try:
        rows = np.loadtxt(path, delimiter=",", skiprows=1, dtype=np.dtype(fields), ndmin=1)
    except ValueError as error:
        raise InputError(f"{path}: {error}", file=path) from error
    return rows.view(Table)
