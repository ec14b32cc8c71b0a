"""Textures: windows of readings as latent vectors."""

from __future__ import annotations

import os
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from . import _palpate
from ._errors import InputError
from ._setup import Name

__all__ = ["Latents", "encode", "features"]


class Latents(NamedTuple):
    """Latent vectors.

    Attributes:
        rows: The row that each window ended with, shape (windows,).
        z: The vectors, shape (windows, latents).
    """

    rows: npt.NDArray[np.uint64]
    z: npt.NDArray[np.float32]


def features(model: Name = "default") -> list[str]:
    """The columns that a model reads, in their order, as a recording names them."""
    return _palpate.Texture(os.fspath(model)).features()


def encode(
    readings: npt.ArrayLike,
    *,
    model: Name = "default",
    soa_ms: float | None = None,
    rate_hz: float | None = None,
) -> Latents:
    """Encodes every window of a recording, or those that end at an onset.

    Args:
        readings: Raw counts, shape (rows, features); the columns are the model's :func:`features`.
        model: A built-in model, or a file.
        soa_ms: From onset to onset, ms: only the newest window at each onset. Needs ``rate_hz``.
        rate_hz: Rows per second.
    """
    made = _palpate.Texture(os.fspath(model))
    window, columns, latents = made.shape()
    rows = np.asarray(readings)
    if rows.ndim != 2 or rows.shape[1] != columns or rows.dtype.kind not in "uif":
        expected = f"raw counts of shape (rows, {columns}), a column for each of palpate.texture.features()"
        raise InputError.of("readings", expected, f"shape {rows.shape} of {rows.dtype}")
    if len(rows) < window:
        raise InputError.of("readings", f"at least {window} rows, one window", f"{len(rows)} rows")
    if not np.isfinite(rows).all():
        raise InputError.of("readings", "finite counts", "NaN or infinity")
    if (soa_ms is None) != (rate_hz is None):
        raise InputError.of("soa_ms, rate_hz", "both or neither", "one of them")
    grid = None
    if soa_ms is not None and rate_hz is not None:
        for name, value, low, high in (("soa_ms", soa_ms, 1, 1e6), ("rate_hz", rate_hz, 0.1, 1e6)):
            if not low <= value <= high:
                raise InputError.of(name, f"{low} to {high}", repr(value))
        grid = (round(1e6 / rate_hz), round(soa_ms * 1e3))
    given = np.ascontiguousarray(rows, dtype="<f4").tobytes()
    ended, z = made.encode(given, grid)
    return Latents(np.array(ended, np.uint64), np.frombuffer(z, "<f4").reshape(-1, latents))
