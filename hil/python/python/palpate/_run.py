"""Runs of scenes and recordings."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _palpate
from ._errors import InputError
from ._setup import Name, module_rows, seed as checked_seed, setup, times
from ._table import Table, table


#: Tables that a run of several displays has for each, and no other.
_OWN = ("felt", "truth", "warmth", "taxels")
#: Those whose rows do not tell by themselves whose they are.
_NAMED = ("felt", "truth", "warmth")


class _Tables:
    """The tables that a run has, and that each of several displays has of its own."""

    def __init__(self, inner: _palpate.Run, display: int | None = None) -> None:
        self._inner = inner
        self._display = display

    def _table(self, name: str) -> Table:
        return table(self._inner.table(name, self._display))

    @cached_property
    def contacts(self) -> Table:
        """Contacts of every frame.

        frame, time_us, module, contact (stable identity), x_mm, y_mm (on the module), intensity (raw counts),
        level (1 to K_I), members (taxels).
        """
        return self._table("contacts")

    @cached_property
    def frames(self) -> Table:
        """Scans of the driving module: frame, time_us, taxels_in_contact, peak_counts."""
        return self._table("frames")

    @cached_property
    def truth(self) -> Table:
        """Where something truly touched, at the time of each frame: time_us, x_mm, y_mm, force_n."""
        return self._table("truth")

    @cached_property
    def stimuli(self) -> Table:
        """Commands to the wires, or motors.

        time_us, wire (in the display's order), board, channel, on and off (ticks), width (off - on, applied; of a motor its
        level, of 4096 for the highest), requested (as width), pulses, until_us, requested_until_us, reason (why the applied width differs from the
        requested one; empty if it does not).
        """
        return self._table("stimuli")

    @cached_property
    def edges(self) -> Table:
        """Edges of the chips' outputs: time_ns, board, channel, high."""
        return self._table("edges")

    @cached_property
    def felt(self) -> Table:
        """Place and strength of every onset, as the emulated person feels it.

        time_us, target_x_mm and target_y_mm (the contact on the display), inside (of its hull), felt (level not below
        0 dB), x_mm and y_mm (centroid by energy; NaN where no wire moved), amplitude_x_mm and amplitude_y_mm,
        level_db (over threshold; -inf where no wire moved), skin_um (the skin's displacement under the wire that moves it
        most, from end to end), tap, energy_requested, energy_applied, energy_felt (parts
        of one wire's at full drive).
        """
        return self._table("felt")

    @cached_property
    def temperatures(self) -> Table:
        """Temperatures of each wire at every onset: time_us, wire, wire_c, skin_c (0.1 mm deep under it)."""
        return self._table("temperatures")

    @cached_property
    def warmth(self) -> Table:
        """Hottest places over time: time_us, wire_c, skin_c (0.1 mm deep), deep_c (0.4 mm), mean_c (skin_c over 10 s)."""
        return self._table("warmth")

    @cached_property
    def margins(self) -> Table:
        """Every limit, the most used first: name, unit, worst, limit, left, used (share of the limit, from rest)."""
        return self._table("margins")

    @cached_property
    def taxels(self) -> Table:
        """Readings of every taxel: time_us, module, taxel, x, y, z (raw counts), change (from its reference, counts)."""
        return self._table("taxels")

    @cached_property
    def events(self) -> Table:
        """Notes, faults and stops: time_us, text."""
        return self._table("notes")

    def html(self) -> str:
        """The report: one page."""
        return self._inner.html(self._display)

    def _repr_html_(self) -> str:
        page = html.escape(self.html(), quote=True)
        return f'<iframe srcdoc="{page}" style="width:100%;height:720px;border:0"></iframe>'


class Display(_Tables):
    """Results of one of several displays: the tables of :class:`Run`, for this display only.

    Wires are numbered per display; boards and modules as on the whole bench and skin.
    """

    def __init__(self, inner: _palpate.Run, number: int, summary: dict[str, Any]) -> None:
        super().__init__(inner, number)
        self.summary = summary
        """This display's object in ``displays`` of the output of ``hil run --json``."""

    @property
    def name(self) -> str:
        """Name of the display on the bench."""
        return str(self.summary["name"])

    def __repr__(self) -> str:
        s = self.summary
        return f"<palpate.Display {s['name']}: {s['stimuli']} stimuli, {len(self.contacts)} contacts>"


class Run(_Tables):
    """A finished run, as :func:`run` returns it.

    Every table is an array of numpy with named columns. Its docstring states the columns with their units.

    On a bench of several displays each table covers all of them, and :attr:`displays` has the tables of each. There,
    :attr:`felt`, :attr:`truth` and :attr:`warmth` begin with a column ``display``.
    """

    def _table(self, name: str) -> Table:
        if not self.displays or name not in _OWN:
            return super()._table(name)
        each: list[npt.NDArray[Any]] = [display._table(name) for display in self.displays.values()]
        if name in _NAMED:
            each = [_of(display, rows) for display, rows in zip(self.displays, each, strict=True)]
        rows = np.concatenate(each)
        rows = rows[np.argsort(rows["time_us"], kind="stable")]
        rows.flags.writeable = False
        return rows.view(Table)

    @cached_property
    def displays(self) -> Mapping[str, Display]:
        """Displays by name, each with its own tables. Empty on a bench of one display."""
        names = self._inner.displays()
        each = enumerate(zip(names, self.summary["displays"], strict=True)) if names else ()
        return MappingProxyType({name: Display(self._inner, i, own) for i, (name, own) in each})

    @cached_property
    def summary(self) -> dict[str, Any]:
        """Summary, as ``hil run --json`` prints it."""
        found: dict[str, Any] = json.loads(self._inner.summary())
        return found

    @property
    def verdict(self) -> str:
        """Outcome of the run, the gravest that applies.

        ``beyond-the-model``, ``limit-exceeded``, ``failed``, ``stopped``, ``incomplete``, ``not-felt``, ``off-the-pad`` or
        ``ok``.
        """
        return str(self.summary["verdict"])

    @property
    def why(self) -> list[str]:
        """Reasons for the verdict."""
        return list(self.summary["why"])

    @property
    def notes(self) -> list[str]:
        """Remarks, such as a recording that ends too early."""
        return self._inner.notes()

    @cached_property
    def digests(self) -> dict[str, str]:
        """First 16 hex digits of SHA-256: ``trace`` (everything), ``contacts``, ``schedule``. Equal runs have equal ones."""
        return dict(zip(("trace", "contacts", "schedule"), self._inner.digests(), strict=True))

    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Writes a record.

        Args:
            path: The file. Its ending chooses the format: ``.mcap`` (everything), ``.csv`` (contacts), ``.jsonl``
                (schedule), ``.log`` (candump), ``.vcd`` (pins, ticks, temperatures), ``.snap`` (golden), ``.html``
                (report), ``.json`` (summary).
            force: Whether to replace an existing file even if it is no record of this kind.
        """
        self._inner.save(os.fspath(path), force)

    def __repr__(self) -> str:
        s = self.summary
        return (
            f"<palpate.Run {s['scene']} on {s['bench']}, seed {s['seed']}: {s['verdict']}, "
            f"{s['contacts']} contacts, {s['stimuli']} stimuli>"
        )


def _of(display: str, rows: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The rows of a display with a first column that names it."""
    kind = [("display", f"<U{len(display)}"), *((name, rows.dtype[name]) for name in rows.dtype.names or ())]
    made = np.empty(len(rows), kind)
    made["display"] = display
    for name in rows.dtype.names or ():
        made[name] = rows[name]
    return made


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

    The same scene, values and seed give the same result in every process, and the same as ``hil run``. Other threads
    keep running meanwhile. Ctrl-C ends the run.

    Args:
        scene: A built-in scene, a file, or the text of one (TOML, several lines). Default: ``sphere-along``.
        seed: Seed of all randomness.
        bench: A built-in emulated bench or a file. Default: what the scene wants, or ``emulated``.
        set: Values in place of the files' own: ``{"illusion.model": "inverse", "bench.drive.current_ma": 900}``.
        replay: Readings in place of the scene's touches: a file (CSV or .npy; candump log or MCAP of all buses), one
            file per module, or arrays of raw counts, of shape (rows, taxels, axes) or (rows, taxels * axes).
        layout: The skin of the readings. Default: the scene's.
        rate_hz: Rows per second of a recording without times.
        time_us: Times of the arrays' rows, microseconds, in place of ``rate_hz``; a list for a list of arrays.
        observe: Whether the guard only notes what it would change, and changes nothing.

    Raises:
        InputError: An argument or a file is unusable; the error has file, key and hint.
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
