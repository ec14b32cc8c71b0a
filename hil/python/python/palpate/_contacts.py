"""Compression alone."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _palpate
from ._errors import InputError
from ._setup import Name, counts as checked_counts, seed as checked_seed, times
from ._table import Table, table

# Rows that are looked at together: some megabytes of a recording that may lie on a disk.
_CHUNK = 1 << 14


def contacts(
    counts: npt.ArrayLike,
    layout: Name,
    *,
    rate_hz: float | None = None,
    time_us: npt.ArrayLike | None = None,
    kc: int = 1,
    ki: int = 10,
    reference_frames: int = 10,
    threshold: float | Literal["auto", "per-taxel"] = "per-taxel",
    weight_exponent: float = 1.0,
    norm: Literal["l1", "l2", "linf"] = "l2",
    axes: Literal["xyz", "z"] = "xyz",
    scope: Literal["module", "skin"] = "module",
    vectors: bool = False,
    drift_s: float | None = None,
    faulty_deviations: float | None = None,
    skip_repeats: bool = False,
    seed: int = 1,
) -> Table:
    """Finds the contacts of every frame: (4.1) to (4.10), as ``hil contacts`` does.

    The function reads the array piece by piece, so ``numpy.load(.., mmap_mode="r")`` may be larger than the memory.
    Memory grows only with the number of contacts found.

    Args:
        counts: Raw counts of the whole skin, shape (rows, taxels, axes) or (rows, taxels * axes).
        layout: The skin, a name or a file.
        rate_hz: Rows per second.
        time_us: Time of each row, microseconds, in place of ``rate_hz``.
        kc: Largest number of contacts per module.
        ki: Intensity levels, found over the whole recording.
        reference_frames: Rows without contact at the start that make the reference.
        threshold: ``"per-taxel"`` (from every taxel's own noise), ``"auto"`` (as published: the largest value of the first
            row after the reference) or raw counts.
        weight_exponent: Exponent p of the weights ``||s||^p``, 0 to 16.
        norm: Norm of the weights.
        axes: Axes to use: all three, or the normal one.
        scope: Whether ``kc`` and ``ki`` apply to each module or to the whole skin.
        vectors: Whether intensities and levels are found along x, y and z, (4.9) to (4.15), in place of their magnitudes;
            levels are numbered by strength.
        drift_s: Time constant with which the reference follows taxels that are not in contact, s. Default: 5 with
            per-taxel thresholds; with other thresholds the reference stays fixed.
        faulty_deviations: Leave out taxels whose first row is more than so many standard deviations from their axis's
            mean.
        skip_repeats: Leave out rows that repeat the row before.
        seed: Seed of the k-means++ draws.

    Returns:
        frame, time_us, module, contact, x_mm, y_mm, intensity (raw counts), level, members: as ``Run.contacts``.
    """
    for name, value, low, high in (
        ("kc", kc, 1, 1024),
        ("ki", ki, 1, 256),
        ("reference_frames", reference_frames, 1, 100_000),
        ("weight_exponent", weight_exponent, 0, 16),
        ("drift_s", drift_s, 0.01, 86_400),
        ("faulty_deviations", faulty_deviations, 0.01, 86_400),
    ):
        if value is not None and not low <= value <= high:
            raise InputError.of(name, f"{low} to {high}", repr(value))
    if (rate_hz is None) == (time_us is None):
        expected = "rate_hz or time_us, which say when the rows came"
        raise InputError.of("counts", expected, "neither" if time_us is None else "both")
    if rate_hz is not None and not 0.1 <= rate_hz <= 1e6:
        raise InputError.of("rate_hz", "0.1 to 1e6 Hz", repr(rate_hz))
    finder = _palpate.Finder(
        os.fspath(layout),
        {
            "kc": kc,
            "reference_frames": reference_frames,
            "threshold": str(threshold),
            "weight_exponent": weight_exponent,
            "norm": norm,
            "axes": axes,
            "scope": scope,
            "vectors": vectors,
            "drift_s": drift_s,
            "faulty_deviations": faulty_deviations,
            "skip_repeats": skip_repeats,
            "seed": checked_seed(seed),
        },
    )
    taxels, each = finder.shape()
    rows: Any = counts if isinstance(counts, np.ndarray) else np.asarray(counts)
    if rows.shape[1:] not in ((taxels, each), (taxels * each,)):
        expected = f"shape (rows, {taxels}, {each}) or (rows, {taxels * each})"
        raise InputError.of("counts", expected, f"shape {rows.shape}")
    came = None if time_us is None else times(time_us, len(rows), "time_us")

    def piece(begin: int) -> tuple[bytes, bytes]:
        found = checked_counts(rows[begin : begin + _CHUNK], "counts")
        if came is not None:
            at = came[begin : begin + _CHUNK]
        else:
            assert rate_hz is not None
            numbers = np.arange(begin, begin + len(found))
            at = np.rint(numbers * (1e6 / rate_hz)).astype(np.uint64)
        return at.tobytes(), found.tobytes()

    for at, found in _ahead(piece, range(0, len(rows), _CHUNK)):
        finder.rows(at, found)
    count = finder.end(ki)
    made = np.empty(count, table(finder.contacts(0, 0)).dtype)
    for begin in range(0, count, _CHUNK):
        made[begin : begin + _CHUNK] = table(finder.contacts(begin, _CHUNK))
    made.flags.writeable = False
    return made.view(Table)


def _ahead(make: Callable[[int], tuple[bytes, bytes]], begins: range) -> Iterator[tuple[bytes, bytes]]:
    """Pieces of the array, read one ahead: the disk reads while the compiled module computes."""
    if len(begins) < 2:
        yield from map(make, begins)
        return
    with ThreadPoolExecutor(1) as reader:
        coming: Future[tuple[bytes, bytes]] = reader.submit(make, begins[0])
        for begin in begins[1:]:
            made, coming = coming.result(), reader.submit(make, begin)
            yield made
        yield coming.result()
