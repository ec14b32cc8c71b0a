"""Rows of `hil reproduce --json` computed anew from the thesis's equations, with nothing but Python.

    thesis.py < rows.json

Each row states its inputs and its results; here the results follow from the inputs.
"""

import itertools
import json
import math
import sys

rows = {row["id"]: row["values"] for row in json.load(sys.stdin)}
checked = []


def near(what, ours, theirs, tolerance=1e-4):
    """The same numbers, however deep their lists are, to a relative and absolute tolerance."""
    if isinstance(ours, (list, tuple)):
        if len(ours) != len(theirs):
            sys.exit(f"{what}: {len(ours)} numbers here, {len(theirs)} there")
        for a, b in zip(ours, theirs):
            near(what, a, b, tolerance)
    elif abs(ours - theirs) > tolerance * max(1.0, abs(ours)):
        sys.exit(f"{what}: {ours} by the equation, {theirs} by the program")


def row(name):
    def check(function):
        function(rows[name])
        checked.append(name)

    return check


def mean_frame(frames):
    return [[sum(f[t][a] for f in frames) / len(frames) for a in range(3)] for t in range(16)]


def relative(v):
    """(4.2)"""
    rest = mean_frame(v["reference_frames"])
    return [[abs(s - r) for s, r in zip(*taxel)] for taxel in zip(v["frame"], rest)]


@row("claim-3.4.1-windows")
def _(v):
    windows = v["rows"] - v["window"] + 1
    near("windows", [64 * windows, 12 * windows, 4 * windows], v["ours"], 0)
    whole = 6335 + 1188 + 397
    strides = [s for s in range(1, v["window"] + 1) if 80 * ((v["rows"] - v["window"]) // s + 1) == whole]
    near("strides", strides, v["strides"], 0)
    # What a split of all windows gives in floating point.
    train, test = int(whole * (1 - 0.15 - 0.05)), int(whole * 0.15)
    near("split", [train, test, whole - train - test], v["by_window"], 0)


@row("tab-3.1")
def _(v):
    def gru(inputs, units):
        return 3 * (inputs * units + units * units + 2 * units)

    encoder = sum(gru(i, u) for i, u in v["layers"])
    units = [u for _, u in reversed(v["layers"])]
    decoder = sum(gru(i, u) for i, u in zip([units[0], *units], units))
    decoder += units[-1] * v["features"] + v["features"]
    near("parameters", [encoder, decoder, encoder + decoder], [v["encoder"], v["decoder"], v["all"]], 0)


@row("eq-3.1")
def _(v):
    found = []
    for wire in range(3):
        mu = v["lead_ms"] + wire * v["delta_mu_ms"]
        bell = [math.exp(-((t - mu) ** 2) / (2 * v["sigma_ms"] ** 2)) for t in v["times_ms"]]
        found.append([v["alpha"] + v["beta"] * b for b in bell])
    near("probabilities", found, v["probabilities"])


@row("eq-3.2")
def _(v):
    low, high = v["z_limits"]

    def control(z, ends):
        z = min(max(z, low), high)
        return (ends[0] - ends[1]) / (low - high) * (z - high) + ends[1]

    ends = [v["delta_mu_ms"], v["sigma_ms"], v["rate_hz"]]
    near("controls", [[control(z, e) for e in ends] for z in v["z"]], v["found"])


@row("sec-4.3.3-faulty")
def _(v):
    found = []
    for taxel in range(16):
        for axis in range(3):
            values = [r[axis] for r in v["readings"]]
            mean = sum(values) / 16
            deviation = math.sqrt(sum((x - mean) ** 2 for x in values) / 16)
            if abs(values[taxel] - mean) > v["deviations"] * deviation and taxel not in found:
                found.append(taxel)
    near("faulty", found, v["faulty"], 0)


@row("eq-4.2")
def _(v):
    near("relative frame", relative(v), v["relative"])


@row("eq-4.3")
def _(v):
    near("threshold", max(max(taxel) for taxel in relative(v)), v["threshold"])


def assign(v, centroids):
    """(4.5) and (4.6)"""
    places = zip(v["x_mm"], v["y_mm"])
    return [min(range(2), key=lambda k: math.dist(p, centroids[k])) for p in places]


@row("eq-4.5-to-4.8")
def _(v):
    centroids = v["seeds_mm"]
    while True:
        own = assign(v, centroids)
        new = []
        for k in range(2):
            w = [w if a == k else 0 for w, a in zip(v["weights"], own)]
            new.append([sum(a * b for a, b in zip(w, v[axis])) / sum(w) for axis in ("x_mm", "y_mm")])
        moved = sum(math.dist(a, b) for a, b in zip(centroids, new)) / 2
        centroids = new
        if moved <= v["zeta_c_mm"]:
            break
    near("centroids", centroids, v["centroids_mm"], 1e-3)
    near("assigned", own, v["assigned"], 0)


@row("eq-4.7-as-printed")
def _(v):
    whole = [sum(w * p for w, p in zip(v["weights"], v[axis])) for axis in ("x_mm", "y_mm")]
    near("centroid", [s / sum(v["weights"]) for s in whole], v["centroid_mm"])
    near("as printed", [s / len(v["weights"]) for s in whole], v["as_printed_mm"])


def between(values, pitch, place):
    """(4.9), bilinear on the module of 4 x 4 taxels"""
    column, line = place[0] / pitch + 1.5, 1.5 - place[1] / pitch
    c, r = min(int(column), 2), min(int(line), 2)
    right, down = column - c, line - r
    upper = (1 - right) * values[4 * r + c] + right * values[4 * r + c + 1]
    lower = (1 - right) * values[4 * r + 4 + c] + right * values[4 * r + 4 + c + 1]
    return (1 - down) * upper + down * lower


@row("eq-4.9")
def _(v):
    near("intensity", between(v["magnitude"], v["pitch_mm"], v["place_mm"]), v["intensity"], 1e-3)


@row("eq-4.10-to-4.14")
def _(v):
    """The best of all splits of the sorted intensities into K_I runs."""
    values = sorted(v["intensities"])

    def cost(run):
        mean = sum(run) / len(run)
        return sum((x - mean) ** 2 for x in run), mean

    best = None
    for cuts in itertools.combinations(range(1, len(values)), v["k_i"] - 1):
        edges = [0, *cuts, len(values)]
        runs = [cost(values[a:b]) for a, b in zip(edges, edges[1:])]
        whole = sum(c for c, _ in runs)
        if best is None or whole < best[0]:
            best = (whole, [m for _, m in runs])
    near("levels", best[1], v["levels"])


@row("eq-4.15")
def _(v):
    nearest = [min(v["levels"], key=lambda level: (abs(level - x), level)) for x in v["intensities"]]
    near("compressed", nearest, v["compressed"])


@row("eq-4.9-to-4.15-vectors")
def _(v):
    axes = list(zip(*v["readings"]))
    vectors = [[between(axis, v["pitch_mm"], place) for axis in axes] for place in v["places_mm"]]
    near("vectors", vectors, v["vectors"], 1e-3)
    # The best of all ways to share the vectors out.
    best = None
    for own in itertools.product(range(v["k_i"]), repeat=len(vectors)):
        if own[0] or len(set(own)) < v["k_i"]:
            continue
        cost, means = 0, []
        for k in range(v["k_i"]):
            cluster = [x for x, a in zip(vectors, own) if a == k]
            means.append([sum(x) / len(cluster) for x in zip(*cluster)])
            cost += sum(math.dist(x, means[k]) ** 2 for x in cluster)
        if best is None or cost < best[0]:
            best = (cost, sorted(means, key=lambda m: math.hypot(*m)))
    near("levels", best[1], v["levels"], 1e-3)
    level = [min(range(v["k_i"]), key=lambda k: math.dist(x, best[1][k])) + 1 for x in vectors]
    near("level", level, v["level"], 0)


@row("claim-4.6-jnd")
def _(v):
    span = math.log(v["highest"] / v["lowest"])
    near("levels", [int(span / math.log1p(w) + 1e-6) + 1 for w in v["fractions"]], v["levels"], 0)


@row("eq-5.1")
def _(v):
    duty = [0 if a == 0 else v["alpha"] + v["beta"] * a for a in v["activations"]]
    near("ticks", [round(4096 * d) for d in duty], v["ticks"], 0)


def phantom(distance, gap, shape=1.0):
    """One factor of (5.2)"""
    return max(1 - (math.log2(abs(distance) + 1) / math.log2(gap + 1)) ** shape, 0)


@row("eq-5.2")
def _(v):
    gap = v["gap_mm"]
    found = [[phantom(x - n * gap, gap, v["shape"]) for n in range(3)] for x in v["places_mm"]]
    near("activations", found, v["activations"])


@row("claim-5.5-centre")
def _(v):
    dips = [10 * math.log10(2 * phantom(gap / 2, gap) ** 2) for gap in v["gaps_mm"]]
    near("dips", dips, v["dip_db"], 1e-3)
    near("flat", [0.0] * 3, v["flat_db"], 1e-3)


@row("claim-5.4-soa")
def _(v):
    near("onsets", 0.32 * v["tau_d_ms"] + 47.3, v["soa_ms"])


@row("claim-5.4-power")
def _(v):
    near("power", 1e3 * v["current_a"] ** 2 * v["resistance_ohm"] * v["duty"], v["power_mw"])
    near("current", math.sqrt(0.180 / (1.9 * 0.0244)), v["follows_a"])


@row("claim-5.4-pwm")
def _(v):
    near("frequencies", [v["clock_hz"] / (4096 * (pre + 1)) for pre in v["prescale"]], v["hz"], 1e-3)


print(f"{len(checked)} rows of the thesis computed anew: {', '.join(checked)}")
