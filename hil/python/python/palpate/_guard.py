"""The guard's answer to a schedule, without a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _palpate
from ._errors import InputError
from ._setup import Name, setup
from ._table import Table, table


@dataclass(frozen=True)
class Verdict:
    """A schedule as the guard would limit it.

    Attributes:
        stimuli: A row per stimulus, as ``Run.stimuli``: ``width`` is the applied width, ``reason`` tells why it
            differs from the requested one.
        peak_c: Hottest skin 0.1 mm deep that the guard predicts for what it applies, degrees C.
        mean_c: Hottest mean over 10 s of the skin 0.1 mm deep, degrees C.
        deep_c: Hottest skin 0.4 mm deep, degrees C.
        omega: Henriques' damage integral.
        cem43_min: Cumulative equivalent minutes at 43 degrees C.
    """

    stimuli: Table
    peak_c: float
    mean_c: float
    deep_c: float
    omega: float
    cem43_min: float


def guard(
    time_us: npt.ArrayLike,
    wire: npt.ArrayLike,
    width: npt.ArrayLike,
    length_us: npt.ArrayLike,
    *,
    bench: Name | None = None,
    set: Mapping[str, object] | None = None,
) -> Verdict:
    """Returns stimuli as the guard would limit them. Drives nothing.

    Stimuli of equal time form one onset. When a stimulus begins, every wire of its board that is still on goes off.

    Args:
        time_us: Start of each stimulus, microseconds, in ascending order (equal times are allowed).
        wire: Wire of each stimulus, in the display's order, zero-based.
        width: Pulse width of each stimulus, ticks (a PWM period has 4096).
        length_us: Duration of each stimulus, microseconds.
        bench: The bench with its limits. Default: ``emulated``.
        set: Values in place of the files' own.
    """
    names = ("time_us", "wire", "width", "length_us")
    mosts = (2**53, 65_535, 4096, 2**53)
    columns = []
    for name, most, values in zip(names, mosts, (time_us, wire, width, length_us), strict=True):
        found = np.atleast_1d(np.asarray(values))
        expected = f"whole numbers from 0 to {most}"
        if found.dtype.kind not in "uif" or found.ndim != 1:
            raise InputError.of(name, expected, f"shape {found.shape} of {found.dtype}")
        if found.size and not ((found >= 0) & (found <= most) & (found == np.rint(found))).all():
            raise InputError.of(name, expected, repr(values))
        columns.append(found)
    rows = max(map(len, columns))
    if any(len(column) not in (1, rows) for column in columns):
        lengths = ", ".join(f"{name} {len(column)}" for name, column in zip(names, columns, strict=True))
        raise InputError.of("stimuli", "as many of each, or one for all", lengths)
    every = [np.broadcast_to(column, rows) for column in columns]
    if (np.diff(every[0].astype(np.int64)) < 0).any():
        raise InputError.of("time_us", "times that do not fall", repr(time_us))
    wanted = [(int(t), int(w), int(ticks), int(us)) for t, w, ticks, us in zip(*every, strict=True)]
    stimuli, predicted = _palpate.guard(setup(None, bench=bench, set=set), wanted)
    return Verdict(table(stimuli), *predicted)
