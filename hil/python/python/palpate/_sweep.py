"""Many runs, on threads, processes or a cluster."""

from __future__ import annotations

import json
import os
import queue
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from . import _palpate
from ._errors import InputError
from ._setup import Name, seed as checked_seed, setup, toml
from ._table import Table

# So many batches are handed to an executor before the first is back: enough for a cluster, and no million in memory.
_AHEAD = 512

# (scene, text, bench): what a worker reads its files by.
_Base = tuple[str | None, str | None, str | None]


class Executor(Protocol):
    """Anything with ``submit``: a pool of threads or processes, ``distributed.Client(..).get_executor()``, ..."""

    def submit(self, fn: Any, /, *args: Any) -> Any:
        """Begins ``fn(*args)`` and returns its future (``add_done_callback``, ``result``, ``cancel``)."""


class RayExecutor:
    """The workers of Ray as an executor. Ray has to be installed and ``ray.init`` called."""

    def submit(self, fn: Any, /, *args: Any) -> Future[Any]:
        """Begins ``fn(*args)`` on a worker of Ray."""
        future: Future[Any] = _remote(fn).remote(*args).future()
        return future


@lru_cache(maxsize=8)
def _remote(fn: Any) -> Any:
    """A function as Ray sends it to its workers, once."""
    import ray

    return ray.remote(fn)


@lru_cache(maxsize=8)
def _base(base: _Base) -> _palpate.Setup:
    scene, text, bench = base
    return _palpate.Setup(scene, text, bench, [], None, [], False)


def _batch(base: _Base, values: list[tuple[str, str]], seeds: list[int]) -> list[str]:
    """A worker's part: computes the rows of some runs."""
    return _palpate.sweep_rows(_base(base), values, seeds)


def sweep(
    scene: Name,
    grid: Mapping[str, Iterable[object]],
    *,
    bench: Name | None = None,
    executor: Executor | None = None,
    batch: int = 10,
    out: str | os.PathLike[str] = "runs.jsonl",
    force: bool = False,
) -> Table:
    """Runs a scene over every combination of values, one row per run.

    The sweep writes rows as they come. After an interruption or a crash of the driver, the same call continues it. The
    finished table has the same bytes on every executor, in every order of runs, and from ``hil sweep``.

    Args:
        scene: A built-in scene, a file, or the text of one. Workers of a cluster read files by the same paths.
        grid: Keys with their values: ``{"illusion.alpha": [0, 0.1], "bench.drive.current_ma": [900, 1970],
            "seed": range(1, 101)}``. Every combination runs with every seed; without ``seed``, with 1.
        bench: A built-in emulated bench or a file. Default: what the scene wants, or ``emulated``.
        executor: Executor of the runs. Default: as many threads as there are cores.
        batch: Number of runs of one combination that a worker takes at once.
        out: File of the table, ``.jsonl`` or ``.csv``. The sweep does not repeat rows that it already has.
        force: Whether to replace a file that is no table of a sweep, and rows of another sweep.

    Returns:
        A row per run, in the order of the grid: the keys of the grid, seed, verdict, why, and the figures (NaN where a
        run does not measure one).

    Raises:
        InputError: A key or value is invalid, the table is another sweep's, or a worker has another version.
    """
    if not 1 <= batch <= 10_000:
        raise InputError.of("batch", "1 to 10000", repr(batch))
    axes = [
        (key, [toml(value, f"grid[{key!r}]") for value in values])
        for key, values in grid.items()
        if key != "seed"
    ]
    seeds = [checked_seed(int(str(value))) for value in grid.get("seed", [1])]
    text = str(scene) if isinstance(scene, str) and "\n" in scene else None
    base: _Base = (
        None if text is not None else _found(scene),
        text,
        None if bench is None else _found(bench),
    )
    made = setup(scene, bench=bench, set=None)
    table = _palpate.Sweep(made, axes, seeds, os.fspath(out), force)
    try:
        if executor is None:
            with ThreadPoolExecutor(os.cpu_count()) as threads:
                _run(table, base, threads, batch)
        else:
            _run(table, base, executor, batch)
        return _rows(table.finish(), [key for key, _ in axes])
    finally:
        table.close()


def _found(name: Name) -> str:
    """A file by its whole path, so that a worker in another folder finds it; a built-in one by its name."""
    path = os.fspath(name)
    return os.path.abspath(path) if os.path.exists(path) else path


def _pieces(table: _palpate.Sweep, batch: int) -> Iterator[tuple[int, list[int]]]:
    lacking = table.lacking()
    begin = 0
    while begin < len(lacking):
        combination = lacking[begin][0]
        end = begin
        while end < len(lacking) and end - begin < batch and lacking[end][0] == combination:
            end += 1
        yield combination, [seed for _, seed in lacking[begin:end]]
        begin = end


def _run(table: _palpate.Sweep, base: _Base, executor: Executor, batch: int) -> None:
    done: queue.SimpleQueue[Any] = queue.SimpleQueue()
    running: dict[int, tuple[int, list[int], Any]] = {}
    pieces = _pieces(table, batch)
    number = 0
    try:
        while True:
            while len(running) < _AHEAD and (piece := next(pieces, None)) is not None:
                combination, seeds = piece
                future = executor.submit(_batch, base, table.set(combination), seeds)
                running[number] = (combination, seeds, future)
                future.add_done_callback(lambda _, n=number: done.put(n))
                number += 1
            if not running:
                return
            combination, seeds, future = running.pop(done.get())
            rows: list[str] = future.result()
            if len(rows) != len(seeds):
                raise InputError.of("a worker", f"{len(seeds)} rows", f"{len(rows)}")
            for seed, row in zip(seeds, rows, strict=True):
                table.add(combination, seed, row)
    finally:
        for _, _, future in running.values():
            future.cancel()


def _rows(lines: list[str], keys: list[str]) -> Table:
    rows = [json.loads(line) for line in lines]
    columns: dict[str, np.ndarray[Any, Any]] = {}
    for key in keys:
        columns[key] = _values([row["set"][key] for row in rows])
    columns["seed"] = np.array([row["seed"] for row in rows], np.uint64)
    for name in ("verdict", "why"):
        columns[name] = np.array([row[name] for row in rows], np.str_)
    figures = list(rows[0])[list(rows[0]).index("why") + 1 :]
    for name in figures:
        values = [row[name] for row in rows]
        columns[name] = np.array([np.nan if v is None else v for v in values], np.float64)
    made = np.empty(len(rows), [(name, values.dtype) for name, values in columns.items()])
    for name, column in columns.items():
        made[name] = column
    made.flags.writeable = False
    return made.view(Table)


def _values(texts: list[str]) -> np.ndarray[Any, Any]:
    """The values of a key: numbers where all are, else words."""
    try:
        return np.array([float(text) for text in texts])
    except ValueError:
        return np.array([text.strip("\"'") for text in texts], np.str_)
