"""What callers state of scenes, benches and readings, as the compiled module takes it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _palpate
from ._errors import InputError

#: A name of a built-in file, or a path.
Name = str | os.PathLike[str]


def toml(value: object, key: str) -> str:
    """A value as TOML has it."""
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, int | np.integer):
        return str(int(value))
    if isinstance(value, float | np.floating):
        return repr(float(value))
    if isinstance(value, str):
        if any(ord(c) < 32 for c in value):
            raise InputError.of(key, "a value on one line", repr(value))
        return value
    if isinstance(value, os.PathLike):
        return toml(os.fspath(value), key)
    if isinstance(value, Mapping):
        inner = (f"{name} = {quoted(item, key)}" for name, item in value.items())
        return "{ " + ", ".join(inner) + " }"
    if isinstance(value, Sequence | np.ndarray):
        return "[" + ", ".join(quoted(item, key) for item in value) + "]"
    raise InputError.of(key, "a number, a truth, a text or a list of these", repr(value))


def quoted(value: object, key: str) -> str:
    """The same inside a list, where a text needs its quotes."""
    text = toml(value, key)
    if not isinstance(value, str):
        return text
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def pairs(changes: Mapping[str, object] | None) -> list[tuple[str, str]]:
    """Keys of files with their values."""
    return [(key, toml(value, f"set[{key!r}]")) for key, value in (changes or {}).items()]


def setup(
    scene: Name | None,
    *,
    bench: Name | None,
    set: Mapping[str, object] | None,
    layout: Name | None = None,
    replay: Sequence[str] = (),
    observe: bool = False,
) -> _palpate.Setup:
    """A checked setup."""
    text = None
    if isinstance(scene, str) and "\n" in scene:
        scene, text = None, scene
    return _palpate.Setup(
        None if scene is None else os.fspath(scene),
        text,
        None if bench is None else os.fspath(bench),
        pairs(set),
        None if layout is None else os.fspath(layout),
        list(replay),
        observe,
    )


def seed(value: int) -> int:
    """A seed."""
    if not 0 <= value < 2**64:
        raise InputError.of("seed", "a whole number from 0 to 2**64 - 1", repr(value))
    return int(value)


def counts(values: npt.ArrayLike, what: str) -> npt.NDArray[np.uint16]:
    """Raw counts: whole numbers from 0 to 65535, of whatever type they are held in."""
    found = np.asarray(values)
    if found.dtype == np.uint16:
        return found
    expected = "raw counts, whole numbers from 0 to 65535"
    if found.dtype.kind not in "uif":
        raise InputError.of(what, expected, f"an array of {found.dtype}")
    if found.size == 0:
        return found.astype(np.uint16)
    if found.dtype.kind == "f":
        if not np.isfinite(found).all():
            raise InputError.of(what, expected, "NaN or infinity", "leave rows out that were not read")
        if (found != np.rint(found)).any():
            raise InputError.of(
                what,
                expected,
                f"fractions such as {float(found[found != np.rint(found)][0])!r}",
                "newtons are no counts: Loop(.., skin=\"emulated\").touch takes forces",
            )
    low, high = found.min(), found.max()
    if low < 0 or high > 65535:
        raise InputError.of(
            what,
            expected,
            f"values from {low} to {high}",
            "differences from a reference are no raw counts: add the reference",
        )
    return found.astype(np.uint16)


def times(values: npt.ArrayLike, rows: int, what: str) -> npt.NDArray[np.uint64]:
    """Times of rows, microseconds that do not fall."""
    found = np.asarray(values)
    expected = f"{rows} times in whole microseconds that do not fall"
    if found.shape != (rows,):
        raise InputError.of(what, expected, f"an array of shape {found.shape}")
    if found.dtype.kind not in "uif":
        raise InputError.of(what, expected, f"an array of {found.dtype}")
    if found.dtype.kind == "f" and not np.isfinite(found).all():
        raise InputError.of(what, expected, "NaN or infinity")
    if rows and found.min() < 0:
        raise InputError.of(what, expected, f"{found.min()}")
    if rows > 1 and found.dtype.kind == "f" and found[-1] - found[0] < rows:
        raise InputError.of(what, expected, "less than a microsecond a row", "multiply seconds by 1e6")
    fallen = np.flatnonzero(found[1:] < found[:-1])
    if fallen.size:
        row = int(fallen[0]) + 1
        raise InputError.of(what, expected, f"{found[row]} after {found[row - 1]} in row {row}")
    return found.astype(np.uint64)


def module_rows(
    arrays: Any, taxels: Sequence[int], axes: int, what: str
) -> list[npt.NDArray[np.uint16]]:
    """Rows of raw counts of every module, of shape (rows, taxels, axes) or (rows, taxels * axes)."""
    if isinstance(arrays, np.ndarray) or len(taxels) != 1 or np.ndim(arrays) in (2, 3):
        arrays = [arrays] if len(taxels) == 1 else arrays
    if len(arrays) != len(taxels):
        raise InputError.of(what, f"{len(taxels)} arrays, one per module", f"{len(arrays)}")
    made = []
    for number, (array, count) in enumerate(zip(arrays, taxels, strict=True)):
        name = what if len(taxels) == 1 else f"{what}[{number}]"
        rows = counts(array, name)
        shapes = ((count, axes), (count * axes,)) + (((count,),) if axes == 1 else ())
        if rows.shape[1:] not in shapes:
            expected = f"shape (rows, {count}, {axes}) or (rows, {count * axes})"
            raise InputError.of(name, expected, f"shape {rows.shape}")
        made.append(np.ascontiguousarray(rows).reshape(len(rows), count * axes))
    return made
