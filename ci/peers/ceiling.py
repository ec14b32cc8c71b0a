"""What a second of the emulated module's readings says of a surface at best, by a strong ordinary learner.

    ceiling.py probes TABLE               a table of surfaces with one property at a time over its range
    ceiling.py FOLDER PROBES [...]

Each folder is one of `hil texture strokes --varied`: recordings and materials.csv. Each second one has strokes of the probes, by
which crosstalk is told as `hil texture response` tells it: a span over a foreign property by that over a learner's own. Gradient
boosting learns the logarithm of each property from spectra, deviations and the onset of one second, on materials marked
`trained`, and is asked about the others. The figure is Spearman's rank correlation on those: window by window, and of the means
over a material's windows. `impact` and `sliding` are readings over the module's rest; `window` is the second of sliding less its
first sample, which is all that the network sees. `+ acc` is the same with what the accelerometer of 3 kHz told in that second,
where the folder has it.
"""

import csv
import sys
from pathlib import Path

import numpy as np
from scipy.stats import spearmanr
from sklearn.ensemble import HistGradientBoostingRegressor

SECONDS = 2.0  # of a recording
PROPERTIES = ["relief_um", "wavelength_mm", "friction", "stiffness_n_per_mm"]
BANDS = 12
# Probes: each property's range as `hil texture response` has it, the shares at which the others stand, and the values between.
RANGES = {"relief_um": (5, 350), "wavelength_mm": (0.3, 5), "friction": (0.3, 1.5), "stiffness_n_per_mm": (1, 100)}
SETTINGS = [0.25, 0.5, 0.75]
VALUES = 9


def spectrum(signal: np.ndarray, hz: float, count: int = BANDS) -> np.ndarray:
    """Logarithms of the power in bands from 1.5 Hz to half the rate, the mean over columns."""
    window = np.hanning(len(signal))[:, None]
    power = np.abs(np.fft.rfft((signal - signal.mean(0)) * window, axis=0)) ** 2
    frequency = np.fft.rfftfreq(len(signal), 1 / hz)
    edges = np.geomspace(1.5, hz / 2 + 1e-9, count + 1)
    bands = [power[(frequency >= a) & (frequency < b)] for a, b in zip(edges, edges[1:])]
    return np.array([np.log10(b.mean() + 1) if b.size else 0.0 for b in bands])


def features(rows: np.ndarray, rest: np.ndarray, hz: float) -> np.ndarray:
    """Of one second, counts over rest: (samples, taxels, 3)."""
    counts = rows - rest
    whole = counts.sum(1)
    normal = np.abs(whole[:, 2]) + 1.0
    shear = np.hypot(whole[:, 0], whole[:, 1])
    ratio = shear / normal
    step = np.diff(whole, axis=0)
    found = [normal.mean(), normal.std(), shear.mean(), shear.std(), np.median(ratio), ratio.std()]
    found += [*np.percentile(ratio, [5, 25, 75, 95]), *np.abs(step).max(0), *step.std(0), *(step.std(0) / normal.mean())]
    # The onset: how steep and how far it overshoots.
    peak = int(normal.argmax())
    found += [normal.max() / normal.mean(), peak / hz, np.argmax(normal > 0.1 * normal.max()) / hz]
    relative = whole / normal[:, None]
    for axis in range(3):
        found += [*spectrum(whole[:, [axis]], hz), *spectrum(counts[:, :, axis], hz), *spectrum(1e4 * relative[:, [axis]], hz)]
        found.append(counts[:, :, axis].std(1).mean())
    return np.array(found)


def shaken(rows: np.ndarray, hz: float) -> np.ndarray:
    """Of one second of an accelerometer, milli-g: (samples, 3)."""
    return np.array([*np.log10(rows.std(0) + 1), *np.concatenate([spectrum(rows[:, [axis]], hz, 24) for axis in range(3)])])


def numbers(path: Path) -> np.ndarray:
    """A CSV file of numbers below a header."""
    text = path.read_text().split("\n", 1)
    columns = text[0].count(",") + 1
    return np.fromstring(text[1].replace("\n", ","), sep=",").reshape(-1, columns)


def probes(table: Path) -> None:
    """Surfaces called probe-PROPERTY-SETTING-VALUE."""
    text = 'name = "probes"\ndescription = "One property at a time"\nassumed = "all ranges"\n'
    for number, key in enumerate(RANGES):
        for setting, share in enumerate(SETTINGS):
            for value in range(VALUES):
                text += f'\n[[texture]]\nname = "probe-{number}-{setting}-{value}"\ntrained = false\noctaves = 1.0\n'
                for other, (low, high) in RANGES.items():
                    at = value / (VALUES - 1) if other == key else share
                    text += f"{other} = {low * (high / low) ** at:.6g}\n"
                    if other == "friction":
                        text += f"finger_friction = {low * (high / low) ** at:.6g}\n"
    table.write_text(text)


def crosstalk(said: np.ndarray, labels: np.ndarray, own: int) -> list[float]:
    """A learner's span over each property by that over its own, means over settings and over a probe's strokes."""
    mean = {label: said[labels == label].mean() for label in np.unique(labels)}
    spans = []
    for number in range(len(RANGES)):
        of = [[mean[f"probe-{number}-{s}-{v}"] for v in range(VALUES)] for s in range(len(SETTINGS))]
        spans.append(np.mean([max(values) - min(values) for values in of]))
    return [span / spans[own] for span in spans]


def read(folder: Path):
    """Materials, the rate, and by part of a recording its features and labels."""
    with open(folder / "materials.csv") as table:
        materials = {row["label"]: row for row in csv.DictReader(table)}
    hz = 0.0
    data = {}
    for path in sorted(folder.glob("*_*.csv")):
        rows = numbers(path)
        hz = len(rows) / SECONDS
        rows = rows.reshape(len(rows), -1, 3)
        second, rest = len(rows) // 2, rows[0]
        label = path.stem.rsplit("_", 1)[0]
        parts = {"impact": (rows[:second], rest), "sliding": (rows[second:], rest), "window": (rows[second:], rows[second])}
        found = {name: features(part, base, hz) for name, (part, base) in parts.items()}
        fast = folder / "accelerometer" / path.name
        if fast.exists():
            readings = numbers(fast)
            half, fast_hz = len(readings) // 2, len(readings) / SECONDS
            found["impact + acc"] = np.append(found["impact"], shaken(readings[:half], fast_hz))
            found["window + acc"] = np.append(found["window"], shaken(readings[half:], fast_hz))
        for name, inputs in found.items():
            of = data.setdefault(name, ([], []))
            of[0].append(inputs)
            of[1].append(label)
    return materials, hz, data


def main(folders: list[Path]) -> None:
    print("rank correlation on unseen materials, window by window (mean of a material's windows)")
    for folder, probed in zip(folders[::2], folders[1::2]):
        materials, hz, data = read(folder)
        asked = read(probed)[2]
        trained = sum(m["trained"] == "true" for m in materials.values())
        print(f"\n{folder.name}: {hz:.0f} Hz, {trained} materials to learn from, {len(materials) - trained} unseen")
        print(f"{'second':<14}" + "".join(f"{p:>22}" for p in PROPERTIES))
        for name, (inputs, labels) in data.items():
            x, labels = np.array(inputs), np.array(labels)
            seen = np.array([materials[label]["trained"] == "true" for label in labels])
            line, spans = f"{name:<14}", []
            for number, key in enumerate(PROPERTIES):
                y = np.log([float(materials[label][key]) for label in labels])
                learner = HistGradientBoostingRegressor(max_iter=300, learning_rate=0.05, random_state=1)
                said = learner.fit(x[seen], y[seen]).predict(x[~seen])
                if name.startswith("window"):
                    inputs, of = asked[name]
                    spans.append((key, crosstalk(learner.predict(np.array(inputs)), np.array(of), number)))
                truth, unseen = y[~seen], labels[~seen]
                names = np.unique(unseen)
                means = [said[unseen == n].mean() for n in names]
                truths = [truth[unseen == n][0] for n in names]
                one = spearmanr(said, truth).statistic
                line += f"{one:>13.2f} ({spearmanr(means, truths).statistic:>5.2f}) "
            print(line)
            for key, of in spans:
                print(f"  crosstalk of {key:<22}" + "".join(f"{share:>11.2f}" for share in of))


if __name__ == "__main__":
    if sys.argv[1] == "probes":
        probes(Path(sys.argv[2]))
    else:
        main([Path(argument) for argument in sys.argv[1:]])
