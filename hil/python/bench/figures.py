"""The figures of docs/costs.md: what the wheel costs, in time and memory.

    python hil/python/bench/figures.py [PART ...]

Parts: import run push sweep recording soak. Run it on a machine that does nothing else. `run` is held
against the program that PALPATE_HIL names.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

import palpate
from palpate import _palpate


def resident_mb(kind: str = "RssAnon") -> float:
    """Memory of this process that is no mapped file, MB."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(float(line.split()[1]) for line in lines if line.startswith(kind)) / 1024


def timed(work: object, times: int) -> float:
    """The median of so many, s."""
    took = []
    for _ in range(times):
        begin = time.perf_counter()
        work()  # type: ignore[operator]
        took.append(time.perf_counter() - begin)
    return statistics.median(took)


def part_import() -> None:
    """How long `import palpate` takes in a new interpreter, and numpy, which the first name that is used loads."""
    clock = "time.perf_counter()"
    code = f"import time; a = {clock}; import palpate; b = {clock}; palpate.run; print(b - a, {clock} - b)"
    took = [[float(x) for x in subprocess.check_output([sys.executable, "-c", code]).split()] for _ in range(15)]
    own, first = (statistics.median(column) * 1e3 for column in zip(*took, strict=True))
    print(f"import palpate: {own:.0f} ms; the first name of it, with numpy: {first:.0f} ms more")


def part_run() -> None:
    """A run against a process of the program."""
    own = timed(lambda: palpate.run("sphere-along"), 30)
    print(f"palpate.run: {own * 1e3:.1f} ms (median of 30)")
    program = os.environ.get("PALPATE_HIL")
    if program:
        words = [program, "run", "sphere-along", "--json"]
        theirs = timed(lambda: subprocess.run(words, capture_output=True, check=True), 30)
        print(f"a process of hil: {theirs * 1e3:.1f} ms")


def part_push() -> None:
    """A push of a scan: 10 ms of virtual time with chip, wires, heat and person."""
    loop = palpate.Loop("uskin-4x4")
    counts = np.full((16, 3), 30_000, np.uint16)
    took = []
    for row in range(20_000):
        counts[:, 2] = 30_000 + (row + np.arange(16)) % 2
        counts[5, 2] += 600 * (row >= 60)
        begin = time.perf_counter_ns()
        loop.push(10_000 * (row + 1), counts)
        took.append(time.perf_counter_ns() - begin)
    us = np.array(took[100:]) / 1e3
    print(f"Loop.push: {np.median(us):.1f} us median, {np.percentile(us, 99):.0f} us for 99 of 100")


def swept(folder: Path, workers: int, kind: str, seeds: range) -> float:
    """How long a sweep takes, s."""
    out = folder / f"{kind}-{workers}.jsonl"
    pool = (
        ThreadPoolExecutor(workers)
        if kind == "threads"
        else ProcessPoolExecutor(workers, mp_context=get_context("spawn"))
    )
    with pool:
        # Workers have started, and read their files, before the time counts.
        list(pool.map(time.sleep, [0.2] * workers))
        palpate.sweep("sphere-along", {"seed": range(9001, 9001 + 20 * workers)}, executor=pool, out=folder / "warm.jsonl", force=True)
        begin = time.perf_counter()
        palpate.sweep("sphere-along", {"seed": seeds}, executor=pool, out=out, force=True)
        return time.perf_counter() - begin


def part_sweep() -> None:
    """1000 runs on one worker and on two, and what a sweep adds to the runs themselves."""
    seeds = range(1, 1001)
    base = _palpate.Setup("sphere-along", None, None, [], None, [], False)
    with tempfile.TemporaryDirectory() as folder:
        for kind in ("threads", "processes"):
            one, two = (swept(Path(folder), workers, kind, seeds) for workers in (1, 2))
            print(f"1000 runs, {kind}: {one:.1f} s on one worker, {two:.1f} s on two: {one / two:.2f} times as fast")
        begin = time.process_time()
        _palpate.sweep_rows(base, [], list(seeds))
        alone = time.process_time() - begin
        begin = time.process_time()
        palpate.sweep("sphere-along", {"seed": seeds}, executor=ThreadPoolExecutor(1), out=Path(folder) / "own.jsonl")
        took = time.process_time() - begin
        print(
            f"processor time of 1000 runs: {alone:.1f} s; as a sweep {took:.1f} s, {100 * (took / alone - 1):.1f} % more"
        )


def record(path: Path, rows: int) -> None:
    """A recording of 16 taxels: a press of a second every ten, on one taxel after the other."""
    made = np.lib.format.open_memmap(path, "w+", np.uint16, (rows, 16, 3))
    rng = np.random.default_rng(1)
    for first in range(0, rows, 1 << 16):
        piece = made[first : first + (1 << 16)]
        at = np.arange(first, first + len(piece))
        pressed = (at % 1000 > 900)[:, None] & (np.arange(16) == (at // 1000 % 16)[:, None])
        piece[:] = 30_000 + rng.integers(0, 3, piece.shape)
        piece[:, :, 2] += (600 * pressed).astype(np.uint16)
    made.flush()


def alone_s(counts: np.ndarray[Any, Any]) -> float:
    """Processor time of the compiled module alone for the same, on rows that are in memory already, s."""
    wanted = {
        "kc": 1, "reference_frames": 50, "threshold": "per-taxel", "weight_exponent": 1.0, "norm": "l2", "axes": "xyz",
        "scope": "module", "drift_s": None, "faulty_deviations": None, "skip_repeats": False, "seed": 1,
    }
    finder, took, chunk = _palpate.Finder("uskin-4x4", wanted), 0.0, 1 << 14
    for first in range(0, len(counts), chunk):
        piece = np.ascontiguousarray(counts[first : first + chunk])
        times = np.arange(first, first + len(piece), dtype=np.uint64) * np.uint64(10_000)
        rows, at = piece.tobytes(), times.tobytes()
        begin = time.process_time()
        finder.rows(at, rows)
        took += time.process_time() - begin
    begin = time.process_time()
    finder.end(10)
    return took + time.process_time() - begin


def part_recording(gigabytes: float = 1.0) -> None:
    """Contacts of a recording that lies on a disk, and what memory that takes."""
    rows = int(gigabytes * 1e9 / (16 * 3 * 2))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "recording.npy"
        record(path, rows)
        counts = np.load(path, mmap_mode="r")
        before = resident_mb()
        begin = time.process_time()
        found = palpate.contacts(counts, "uskin-4x4", rate_hz=100, reference_frames=50, threshold="per-taxel")
        took = time.process_time() - begin
        print(
            f"{path.stat().st_size / 1e9:.2f} GB, {rows} rows, {len(found)} contacts: {took:.1f} s of processor "
            f"time, {rows / took / 1e6:.1f} million rows per s"
        )
        print(
            f"memory: {before:.0f} MB before, {resident_mb():.0f} MB with the table of {found.nbytes / 1e6:.0f} MB"
        )
        alone = alone_s(counts)
        print(f"the compiled module alone: {alone:.1f} s; palpate.contacts has {100 * alone / took:.0f} % of its speed")


def part_soak(calls: int = 100_000) -> None:
    """So many calls of every kind, of errors too: memory must not grow."""
    counts = np.full((16, 3), 30_000, np.uint16)
    loop, chip = palpate.Loop("uskin-4x4"), palpate.emulators.Pca9685(0x40)
    short = np.full((60, 16, 3), 30_000, np.uint16)
    short[:, :, 2] += ((np.arange(60)[:, None] + np.arange(16)) % 2).astype(np.uint16)

    def call(number: int) -> None:
        loop.push(10_000 * (number + 1), counts).contacts
        loop.temperatures()
        try:
            loop.push(0, counts)
        except palpate.InputError:
            pass
        chip.advance(1_000)
        if number % 10 == 0:
            palpate.guard(time_us=[0], wire=[0], width=4096, length_us=38_000).stimuli
            palpate.contacts(short, "uskin-4x4", rate_hz=100)
            with palpate.Loop("uskin-4x4"):
                pass
        if number % 1000 == 0:
            palpate.run("sphere-along").felt

    for number in range(calls // 10):
        call(number)
    before = resident_mb()
    for number in range(calls // 10, calls):
        call(number)
    print(f"{calls} calls: {before:.1f} MB after a tenth of them, {resident_mb():.1f} MB at the end")


if __name__ == "__main__":
    parts = {name.removeprefix("part_"): work for name, work in list(globals().items()) if name.startswith("part_")}
    for name in sys.argv[1:] or parts:
        parts[name]()
