"""Runs of scenes and recordings."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _palpate
from ._errors import InputError
from ._setup import Name, module_rows, seed as checked_seed, setup, times
from ._table import Table, table


class Run:
    """A run that is over. :func:`run` makes one.

    Every table is an array of numpy with named columns; its columns are stated here, with units.
    """

    def __init__(self, inner: _palpate.Run) -> None:
        self._inner = inner

    @cached_property
    def summary(self) -> dict[str, Any]:
        """What ``hil run --json`` prints."""
        found: dict[str, Any] = json.loads(self._inner.summary())
        return found

    @property
    def verdict(self) -> str:
        """``ok``, ``limit-exceeded``, ``failed``, ``stopped`` or ``incomplete``."""
        return str(self.summary["verdict"])

    @property
    def why(self) -> list[str]:
        """What the verdict is for."""
        return list(self.summary["why"])

    @property
    def notes(self) -> list[str]:
        """Remarks, such as a recording that ends too early."""
        return self._inner.notes()

    @cached_property
    def contacts(self) -> Table:
        """Contacts of every frame.

        frame, time_us, module, contact (stable identity), x_mm, y_mm (on the module), intensity (raw counts),
        level (1 to K_I), members (taxels).
        """
        return table(self._inner.table("contacts"))

    @cached_property
    def frames(self) -> Table:
        """Scans of the driving module: frame, time_us, taxels_in_contact, peak_counts."""
        return table(self._inner.table("frames"))

    @cached_property
    def truth(self) -> Table:
        """Where something truly touched, at the time of each frame: time_us, x_mm, y_mm, force_n."""
        return table(self._inner.table("truth"))

    @cached_property
    def stimuli(self) -> Table:
        """What the wires were told.

        time_us, wire (in the display's order), board, channel, on and off (ticks), width (off - on, applied),
        requested (width, ticks), pulses, until_us, requested_until_us, reason (why applied is not requested; empty
        where it is).
        """
        return table(self._inner.table("stimuli"))

    @cached_property
    def edges(self) -> Table:
        """Edges of the chips' outputs: time_ns, board, channel, high."""
        return table(self._inner.table("edges"))

    @cached_property
    def felt(self) -> Table:
        """What a person meets of every onset.

        time_us, target_x_mm and target_y_mm (the contact on the display), inside (of its hull), felt (level not below
        0 dB), x_mm and y_mm (centroid by energy; NaN where no wire moved), amplitude_x_mm and amplitude_y_mm,
        level_db (over threshold; -inf where no wire moved), tap, energy_requested, energy_applied, energy_felt (parts
        of one wire's at full drive).
        """
        return table(self._inner.table("felt"))

    @cached_property
    def temperatures(self) -> Table:
        """Of each wire at every onset: time_us, wire, wire_c, skin_c (0.1 mm deep under it)."""
        return table(self._inner.table("temperatures"))

    @cached_property
    def warmth(self) -> Table:
        """The hottest over time: time_us, wire_c, skin_c (0.1 mm deep), deep_c (0.4 mm), mean_c (skin_c over 10 s)."""
        return table(self._inner.table("warmth"))

    @cached_property
    def margins(self) -> Table:
        """Every limit, the most used up first: name, unit, worst, limit, left, used (a part of the limit, from rest)."""
        return table(self._inner.table("margins"))

    @cached_property
    def taxels(self) -> Table:
        """What every taxel read: time_us, module, taxel, x, y, z (raw counts), change (from its reference, counts)."""
        return table(self._inner.table("taxels"))

    @cached_property
    def events(self) -> Table:
        """What is worth a line: time_us, text."""
        return table(self._inner.table("notes"))

    @cached_property
    def digests(self) -> dict[str, str]:
        """First 16 hex digits of SHA-256: ``trace`` (everything), ``contacts``, ``schedule``. Equal runs have equal ones."""
        return dict(zip(("trace", "contacts", "schedule"), self._inner.digests(), strict=True))

    def html(self) -> str:
        """The report: one page."""
        return self._inner.html()

    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Writes a record.

        Args:
            path: The ending says which: ``.mcap`` (everything), ``.csv`` (contacts), ``.jsonl`` (schedule), ``.log``
                (candump), ``.vcd`` (pins, ticks, temperatures), ``.snap`` (golden), ``.html`` (report), ``.json``
                (summary).
            force: Whether a file that is no earlier record of this kind is replaced.
        """
        self._inner.save(os.fspath(path), force)

    def _repr_html_(self) -> str:
        page = html.escape(self.html(), quote=True)
        return f'<iframe srcdoc="{page}" style="width:100%;height:720px;border:0"></iframe>'

    def __repr__(self) -> str:
        s = self.summary
        return (
            f"<palpate.Run {s['scene']} on {s['bench']}, seed {s['seed']}: {s['verdict']}, "
            f"{s['contacts']} contacts, {s['stimuli']} stimuli>"
        )


def run(
    scene: Name | None = None,
    *,
    seed: int = 1,
    bench: Name | None = None,
    set: Mapping[str, object] | None = None,
    replay: Name | Sequence[Name] | npt.NDArray[Any] | Sequence[npt.NDArray[Any]] | None = None,
    layout: Name | None = None,
    rate_hz: float | None = None,
    time_us: npt.ArrayLike | Sequence[npt.ArrayLike] | None = None,
    observe: bool = False,
) -> Run:
    """Runs a scene, or a recording, on an emulated bench.

    The same scene, values and seed give the same result, in every process and as ``hil run`` gives it. Other threads
    go on meanwhile, and Ctrl-C ends it.

    Args:
        scene: A built-in scene, a file, or the text of one (TOML, several lines). Default: ``sphere-along``.
        seed: Seed of all randomness.
        bench: A built-in emulated bench or a file. Default: ``emulated``.
        set: Values in place of the files' own: ``{"illusion.model": "inverse", "bench.drive.current_ma": 900}``.
        replay: Readings in place of the scene's touches: a file (CSV or .npy; candump log or MCAP of all buses), one
            file per module, or arrays of raw counts, of shape (rows, taxels, axes) or (rows, taxels * axes).
        layout: The skin of the readings. Default: the scene's.
        rate_hz: Rows per second, where nothing says when they came.
        time_us: When the rows of arrays came, microseconds, in place of ``rate_hz``; a list where arrays are one.
        observe: The guard changes nothing and notes what it would.

    Raises:
        InputError: What cannot be run, with file, key and hint.
    """
    files: list[str] = []
    arrays: Any = None
    if isinstance(replay, str | os.PathLike):
        files = [os.fspath(replay)]
    elif isinstance(replay, np.ndarray):
        arrays = replay
    elif replay is not None:
        parts = list(replay)
        if parts and all(isinstance(part, str | os.PathLike) for part in parts):
            files = [os.fspath(part) for part in parts]  # type: ignore[arg-type]
        else:
            arrays = parts
    recorded = files or (["an array"] if arrays is not None else [])
    made = setup(scene, bench=bench, set=set, layout=layout, replay=recorded, observe=observe)
    rows: list[tuple[bytes, bytes]] = []
    if arrays is not None:
        rows = _rows(arrays, made, rate_hz, time_us)
    return Run(_palpate.run(made, checked_seed(seed), files, rate_hz, rows))


def _rows(
    arrays: Any, made: _palpate.Setup, rate_hz: float | None, time_us: Any
) -> list[tuple[bytes, bytes]]:
    modules = module_rows(arrays, *made.shape(), "replay")
    if (rate_hz is None) == (time_us is None):
        expected = "rate_hz or time_us, which say when the rows came"
        raise InputError.of("replay", expected, "neither" if time_us is None else "both")
    if rate_hz is not None and not 0.1 <= rate_hz <= 1e6:
        raise InputError.of("rate_hz", "0.1 to 1e6 Hz", repr(rate_hz))
    if time_us is not None and len(modules) == 1:
        time_us = [time_us]
    rows = []
    for number, module in enumerate(modules):
        if rate_hz is not None:
            came = np.rint(np.arange(len(module)) * (1e6 / rate_hz)).astype(np.uint64)
        else:
            came = times(time_us[number], len(module), "time_us")
        rows.append((came.tobytes(), module.tobytes()))
    return rows
