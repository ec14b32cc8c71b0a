"""The loop, stepped by the caller."""

from __future__ import annotations

from collections.abc import Mapping
from types import TracebackType
from typing import Literal

import numpy as np
import numpy.typing as npt

from . import _palpate
from ._errors import InputError
from ._setup import Name, counts as checked_counts, seed as checked_seed, setup
from ._table import Table, table


class Step:
    """Events since the previous step, in tables like those of :class:`Run`. Each table is made on first access."""

    __slots__ = ("_happened",)

    def __init__(self, happened: _palpate.Happened) -> None:
        self._happened = happened

    @property
    def time_us(self) -> int:
        """Virtual time, microseconds."""
        return self._happened.time_us

    @property
    def dropped(self) -> int:
        """Number of events that the loop dropped because nobody took them in time."""
        return self._happened.dropped

    @property
    def contacts(self) -> Table:
        """Contacts, in the columns of :attr:`Run.contacts`."""
        return table(self._happened.table("contacts"))

    @property
    def stimuli(self) -> Table:
        """Stimuli, in the columns of :attr:`Run.stimuli`."""
        return table(self._happened.table("stimuli"))

    @property
    def felt(self) -> Table:
        """Felt onsets, in the columns of :attr:`Run.felt`. An onset's row comes once the next onset begins."""
        return table(self._happened.table("felt"))

    @property
    def edges(self) -> Table:
        """Edges of outputs, in the columns of :attr:`Run.edges`."""
        return table(self._happened.table("edges"))

    @property
    def frames(self) -> Table:
        """Frames, in the columns of :attr:`Run.frames`."""
        return table(self._happened.table("frames"))

    @property
    def events(self) -> Table:
        """Events, in the columns of :attr:`Run.events`."""
        return table(self._happened.table("notes"))


class Loop:
    """The whole loop in virtual time: from readings, or touches, to what a person feels.

    Only :meth:`push` and :meth:`advance` move time, as fast as the processor computes. Several threads may share a
    loop, but only one of them may call it at a time.

    Args:
        layout: The skin, a name or a file. Default: the scene's.
        bench: The emulated bench whose wires or motors are driven. Default: what the scene wants, or ``emulated``.
        scene: The scene that gives the other settings; the loop ignores its touches. Default: the settings of
            ``hil run --replay``, with a contact threshold from every taxel's own noise.
        set: Values in place of the files' own, as for :func:`run`.
        seed: Seed of all randomness.
        skin: ``"pushed"``: the caller gives readings by :meth:`push`. ``"emulated"``: the loop emulates the boards, and
            the caller presses on their skin by :meth:`touch`.
        illusion: ``"scene"``: the scene's illusion. ``"own"``: the caller sets the wires' activations by
            :meth:`activate`. This needs an emulated skin and a model that gives activations, such as ``balanced``.
    """

    def __init__(
        self,
        layout: Name | None = None,
        bench: Name | None = None,
        *,
        scene: Name | None = None,
        set: Mapping[str, object] | None = None,
        seed: int = 1,
        skin: Literal["pushed", "emulated"] = "pushed",
        illusion: Literal["scene", "own"] = "scene",
    ) -> None:
        if skin not in ("pushed", "emulated"):
            raise InputError.of("skin", '"pushed" or "emulated"', repr(skin))
        if illusion not in ("scene", "own"):
            raise InputError.of("illusion", '"scene" or "own"', repr(illusion))
        if illusion == "own" and skin != "emulated":
            raise InputError.of("illusion", '"own" with skin="emulated" only', f"skin={skin!r}")
        made = setup(scene, bench=bench, set=set, layout=layout, replay=["readings of a loop"])
        taxels, axes = made.shape()
        self._shapes = [(count, axes) for count in taxels]
        self._emulated = skin == "emulated"
        self._inner = _palpate.Loop(made, checked_seed(seed), skin == "emulated", illusion == "own")

    @property
    def shapes(self) -> list[tuple[int, int]]:
        """Shape (taxels, axes) of every module's counts, as :meth:`push` takes them."""
        return list(self._shapes)

    @property
    def is_emulated(self) -> bool:
        """Whether its skin is emulated, so that :meth:`touch` presses on it."""
        return self._emulated

    @property
    def time_us(self) -> int:
        """Virtual time, microseconds."""
        return self._inner.time_us()

    @property
    def taxels(self) -> Table:
        """Places of the taxels on their modules, in the order of readings: module, x_mm, y_mm."""
        places = self._inner.taxels()
        kind = [("module", "<u2"), ("x_mm", "<f8"), ("y_mm", "<f8")]
        return np.array(places, dtype=kind).view(Table)

    @property
    def wires(self) -> Table:
        """Places of the wires, or motors, on the display: x_mm, y_mm."""
        return np.array(self._inner.wires(), dtype=[("x_mm", "<f8"), ("y_mm", "<f8")]).view(Table)

    @property
    def soa_us(self) -> int:
        """Time from one onset to the next, microseconds. The first onset is at 0."""
        return self._inner.soa_us()

    def push(self, time_us: int, counts: npt.ArrayLike, *, module: int = 0) -> Step:
        """Hands over one module's scan. Advances virtual time to it, and performs everything that is due by then.

        The first scans make the reference (``reference_frames`` of the scene, 50): let nothing touch the skin
        meanwhile.

        Args:
            time_us: Time at which the scan was complete, microseconds; later than the module's previous scan.
            counts: Raw counts, shape (taxels, axes) or (taxels * axes,).
            module: The module, zero-based.
        """
        if not 0 <= module < len(self._shapes):
            expected = f"0 to {len(self._shapes) - 1}"
            raise InputError.of("module", expected, repr(module))
        found = checked_counts(counts, "counts")
        shape = self._shapes[module]
        if found.shape != shape and found.shape != (shape[0] * shape[1],):
            expected = f"shape {shape} or {(shape[0] * shape[1],)}"
            raise InputError.of("counts", expected, f"shape {found.shape}")
        return Step(self._inner.push(module, _time(time_us, "time_us"), found.tobytes()))

    def advance(self, until_us: int) -> Step:
        """Advances virtual time to ``until_us``, microseconds."""
        return Step(self._inner.advance(_time(until_us, "until_us")))

    def rezero(self, *, forced: bool = False) -> Step:
        """Switches everything off and measures the skin's reference again. Let nothing touch the skin meanwhile.

        The loop refuses this during a contact, unless ``forced``. A note in the step's events states the result.
        """
        return Step(self._inner.rezero(forced))

    def hot_pass(self) -> Step:
        """Heats every wire once, in turn, at the next onsets without a contact. Call it after the display was put on.

        Motors are not heated: a note says so. The person feels each as a tap. Notes in the events of this and later steps state the result.
        """
        return Step(self._inner.hot_pass())

    def touch(
        self,
        places: npt.ArrayLike,
        forces: npt.ArrayLike,
        *,
        diameter_mm: npt.ArrayLike = 8.0,
        module: int = 0,
    ) -> None:
        """Presses on the emulated skin from now on, until the next call. Without places nothing presses.

        Args:
            places: Places on the module, mm, shape (touches, 2), or (2,) for one.
            forces: Normal forces, N, shape (touches,), or a number for all.
            diameter_mm: Diameters of the pressing objects, mm, shape (touches,), or a number for all.
            module: The module, zero-based.
        """
        at = np.asarray(places, dtype=np.float64)
        if at.size == 0:
            at = at.reshape(0, 2)
        at = np.atleast_2d(at)
        if at.ndim != 2 or at.shape[1] != 2:
            raise InputError.of("places", "shape (touches, 2)", f"shape {np.shape(places)}")
        presses = np.empty((len(at), 4))
        presses[:, :2] = at
        for column, name, values, low, high in (
            (2, "forces", forces, 0.0, 1000.0),
            (3, "diameter_mm", diameter_mm, 0.01, 1e6),
        ):
            each = np.asarray(values, dtype=np.float64)
            if each.shape not in ((), (len(at),)):
                raise InputError.of(name, f"a number or shape ({len(at)},)", f"shape {each.shape}")
            if not ((each >= low) & (each <= high)).all():
                raise InputError.of(name, f"{low} to {high}", repr(values))
            presses[:, column] = each
        if not (np.abs(presses[:, :2]) <= 1e6).all():
            raise InputError.of("places", "places on the module, mm", repr(places))
        self._inner.touch(module, presses.tolist())

    @property
    def most_pulses(self) -> int:
        """Largest number of pulses per wire and onset that :meth:`activate` takes."""
        return self._inner.most_pulses()

    def activate(self, values: npt.ArrayLike, pulses: npt.ArrayLike | None = None) -> None:
        """Sets the wires' activations for every later onset with a contact.

        Drive, calibration and guard act on them as on an illusion's activations.

        Args:
            values: Activations, 0 to 1, shape (wires,): parts of full drive, times the weight of the contact's intensity
                unless ``illusion.intensity`` is false.
            pulses: Number of pulses in each wire's burst, whole numbers from 1 to :attr:`most_pulses`, shape (wires,).
                Default: as many as fit in ``illusion.tau_d_ms``.
        """
        each = np.asarray(values, dtype=np.float64)
        expected = "activations from 0 to 1, one per wire"
        if each.ndim != 1:
            raise InputError.of("values", expected, f"shape {each.shape}")
        self._inner.activate(each.tolist(), None if pulses is None else self._pulses(pulses))

    def _pulses(self, pulses: npt.ArrayLike) -> list[int]:
        found, most = np.asarray(pulses), self.most_pulses
        if found.dtype.kind not in "ui" or found.ndim != 1 or not ((found >= 1) & (found <= most)).all():
            raise InputError.of("pulses", f"whole numbers from 1 to {most}, one per wire", repr(pulses))
        each: list[int] = found.tolist()
        return each

    def temperatures(self) -> Table:
        """Temperatures of each wire now: wire_c, skin_c (0.1 mm deep under it), degrees C.

        Raises:
            InputError: The bench has motors, which heat no skin.
        """
        now = self._inner.temperatures()
        made = np.array(now, dtype=[("wire_c", "<f8"), ("skin_c", "<f8")])
        return made.view(Table)

    def close(self) -> None:
        """Frees the loop. Every later call is an error."""
        self._inner.close()

    def __enter__(self) -> Loop:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _time(value: int, what: str) -> int:
    if not 0 <= value < 2**62:
        raise InputError.of(what, "whole microseconds from 0", repr(value))
    return int(value)
