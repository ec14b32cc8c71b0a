"""The guard, asked."""

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
    """What the guard leaves of a schedule.

    Attributes:
        stimuli: A row per stimulus, as ``Run.stimuli``: width is what is applied, reason why it is not what was
            requested.
        peak_c: Hottest skin 0.1 mm deep that the guard predicts for what it applies, degrees C.
        mean_c: The same as a mean over 10 s.
        deep_c: Hottest skin 0.4 mm deep.
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
    """Asks the guard what it would leave of stimuli. Nothing is driven.

    Stimuli of one time come together, as an onset's. A wire that is still on when another stimulus of its board begins
    goes off.

    Args:
        time_us: When each begins, microseconds that do not fall.
        wire: Its wire, in the display's order, zero-based.
        width: Width of its pulses, ticks (4096 are a period of the PWM).
        length_us: How long it lasts, microseconds.
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
