"""Contacts of a large CSV by `hil contacts`, and the same weighted means by polars and pandas, in one run.

    recordings.py HIL [MB]

A finger circles over a pad of 4 x 4 taxels of three axes: 48 columns of raw counts. Each program reads the file, takes the mean
of the first rows for its reference, weighs each taxel above a threshold by its change, and writes the weighted means. It
prints processor and wall seconds (the least of three runs), and what of them the peers' interpreters take to start. It fails
where places differ by more than 5 um.
"""

import math
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

REFERENCE, THRESHOLD, PITCH_MM, ROUNDS, TOLERANCE_MM = 10, 60, 4.7, 3, 0.005
PLACES = [((t % 4 - 1.5) * PITCH_MM, (1.5 - t // 4) * PITCH_MM) for t in range(16)]
NAMES = [f"txl{t + 1}_{axis}" for t in range(16) for axis in "xyz"]


def write(path, megabytes):
    """Rows at rest, then a finger that circles in two seconds. They repeat, because drawing them takes longer than reading."""
    noise = np.random.default_rng(1)
    rows = []
    for row in range(1000):
        counts = 32000 + noise.integers(-3, 4, 48)
        if row >= 40:
            x, y = (4 * f(row * math.pi / 100) for f in (math.cos, math.sin))
            push = [600 * math.exp(-((px - x) ** 2 + (py - y) ** 2) / 20) for px, py in PLACES]
            counts += np.array([[p * 0.1, -p * 0.1, p] for p in push]).ravel().astype(int)
        rows.append(",".join(map(str, counts)))
    with path.open("w") as file:
        file.write("time_us," + ",".join(NAMES) + "\n")
        written, row = 0, 0
        while written < megabytes * 1_000_000:
            touching = row if row < 1000 else 40 + (row - 40) % 800
            written += file.write(f"{row * 10_000},{rows[touching]}\n")
            row += 1


def with_polars(path, out):
    import polars as pl

    relative = {n: pl.col(n) - pl.col(n).head(REFERENCE).mean() for n in NAMES}
    norms = [sum(relative[f"txl{t}_{a}"] ** 2 for a in "xyz").sqrt() for t in range(1, 17)]
    table = pl.scan_csv(path).select("time_us", *[n.alias(f"n{t}") for t, n in enumerate(norms)])
    weights = [pl.when(pl.col(f"n{t}") > THRESHOLD).then(pl.col(f"n{t}")).otherwise(0.0) for t in range(16)]
    total = sum(weights)
    mean = [sum(w * p[axis] for w, p in zip(weights, PLACES)) / total for axis in (0, 1)]
    table = table.filter(total > 0).select("time_us", mean[0].round(3).alias("x_mm"), mean[1].round(3).alias("y_mm"))
    table.collect().write_csv(out)


def with_pandas(path, out):
    import pandas as pd

    table = pd.read_csv(path)
    counts = table[NAMES].to_numpy(np.float32)
    relative = (counts - counts[:REFERENCE].mean(0)).reshape(-1, 16, 3)
    norms = np.sqrt((relative**2).sum(2))
    weights = np.where(norms > THRESHOLD, norms, 0)
    total = weights.sum(1)
    touched = total > 0
    mean = weights[touched] @ np.array(PLACES, np.float32) / total[touched, None]
    found = pd.DataFrame(mean.round(3), columns=["x_mm", "y_mm"])
    found.insert(0, "time_us", table["time_us"].to_numpy()[touched])
    found.to_csv(out, index=False)


def timed(command, out, cores):
    """The least processor seconds and wall seconds of a command, on so many cores."""
    env = os.environ | {name: str(cores) for name in ("POLARS_MAX_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")}
    some = sorted(os.sched_getaffinity(0))[:cores]
    best = [math.inf, math.inf]
    for _ in range(ROUNDS):
        before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        with open(out, "w") as file:
            pinned = lambda: os.sched_setaffinity(0, some)
            subprocess.run(command, stdout=file, check=True, env=env, preexec_fn=pinned)
        wall, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
        best = [min(best[0], cpu), min(best[1], wall)]
    return best


def places(path):
    import csv

    with open(path) as file:
        return {int(r["time_us"]): (float(r["x_mm"]), float(r["y_mm"])) for r in csv.DictReader(file)}


def main():
    hil, megabytes = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 100
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "recording.csv")
        write(file, megabytes)
        size = file.stat().st_size / 1e6
        options = ["--layout", "uskin-4x4", "--threshold", str(THRESHOLD), "--reference-frames", str(REFERENCE), "--quiet"]
        own = [hil, "contacts", str(file), *options]
        print(f"{size:.0f} MB of 48 columns, the least of {ROUNDS} runs")
        reference = None
        for name in ("hil", "polars", "pandas"):
            for cores in (1, 2):
                out = Path(folder, f"{name}-{cores}.csv")
                command = own if name == "hil" else [sys.executable, __file__, name, str(file), str(out)]
                cpu, wall = timed(command, out if name == "hil" else os.devnull, cores)
                print(f"  {name:<7} {cores} cores: {cpu:.2f} s of a processor ({size / cpu:.0f} MB/s), {wall:.2f} s by the clock")
                found = places(out)
                reference = reference or found
                alike = sum(t in found and math.dist(p, found[t]) <= TOLERANCE_MM for t, p in reference.items())
                if alike < len(reference) or len(found) != len(reference):
                    sys.exit(f"{name}: {alike} of {len(reference)} places are those of hil, {len(found)} found")
            if name != "hil":
                start, _ = timed([sys.executable, "-c", f"import numpy, {name}"], os.devnull, 1)
                print(f"  {name:<7} start: {start:.2f} s of a processor")
        print(f"  all {len(reference)} places are alike to {TOLERANCE_MM * 1000:.0f} um")


if __name__ == "__main__":
    if sys.argv[1:2] in (["polars"], ["pandas"]):
        {"polars": with_polars, "pandas": with_pandas}[sys.argv[1]](sys.argv[2], sys.argv[3])
    else:
        main()
