"""Mann-Whitney U by scipy (pinned in requirements.txt): what `hil texture panel` is held against.

    python panel.py oracle > hil/texture/src/panel/oracle.json    samples with many ties and few, and what scipy says
    hil texture panel --json | python panel.py check              every U and p of a panel computed again, to 1e-9
    cat PANELS.json | python panel.py several                     what panels of several seeds come to: how often display and
                                                                  finger agree (Wilson's intervals), and what goes with what

`several` needs nothing but Python.
"""

import json
import math
import sys
from statistics import median


def scipys(a, b):
    from scipy.stats import mannwhitneyu

    found = mannwhitneyu(a, b, alternative="two-sided", method="asymptotic")
    return float(found.statistic), float(found.pvalue)


def oracle():
    import numpy as np

    draw = np.random.default_rng(1)
    sizes = [(12, 12), (12, 12), (12, 36), (4, 4), (1, 1), (3, 8), (40, 25)]
    cases = []
    for top in (1, 2, 6, 200):
        for n, m in sizes:
            for shift in (0, 1):
                a = draw.integers(1, top + 1, n)
                b = np.minimum(draw.integers(1, top + 1, m) + shift, 255)
                u, p = scipys(a, b)
                cases.append({"a": a.tolist(), "b": b.tolist(), "u": u, "p": p})
    return cases


def check(panel):
    worst, count = 0.0, 0
    for texture in panel["textures"]:
        for test in texture["tests"]:
            u, p = scipys(test["a"], test["b"])
            worst = max(worst, abs(u - test["u"]), abs(p - test["p"]))
            count += 1
    print(f"{count} tests, at most {worst:.1e} from scipy's")
    return 0 if count and worst <= 1e-9 else 1


def wilson(hits, z=1.959964):
    """How often it holds, with an interval of 95 %."""
    count, share = len(hits), sum(hits) / len(hits)
    spread = z * z / count
    middle = (share + spread / 2) / (1 + spread)
    half = z * math.sqrt(share * (1 - share) / count + spread / (4 * count)) / (1 + spread)
    return f"{sum(hits)} of {count}: {share:.2f} ({middle - half:.2f} to {middle + half:.2f})"


def several(text):
    """Prints tables of all panels: their textures where they are few, agreement, rank correlations."""
    decoder, panels = json.JSONDecoder(), []
    while text := text.lstrip():
        panel, end = decoder.raw_decode(text)
        panels.append(panel)
        text = text[end:]
    names = [texture["name"] for texture in panels[0]["textures"]]
    agree = {name: [[t["p"] >= 0.05 for t in panel["textures"][n]["tests"]] for panel in panels] for n, name in enumerate(names)}
    if len(names) <= 12:
        print(f"| of {len(panels)} panels | driven | level, dB: median, least | tap, dB: median, least | roughness agrees | friction agrees |")
        print("|---|---:|---:|---:|---:|---:|")
        for n, name in enumerate(names):
            rows = [panel["textures"][n] for panel in panels]
            level, tap = ([row[key] for row in rows] for key in ("level_db", "tap_db"))
            cells = [f"{median(row['driven'] for row in rows):.2f}"]
            cells += [f"{median(of):.1f}, {min(of):.1f}" for of in (level, tap)]
            print("|", " | ".join([name, *cells, *(str(sum(hits)) for hits in zip(*agree[name]))]), "|")
        print()
    print(f"| {len(names)} textures, {len(panels)} panels | display and finger agree |\n|---|---|")
    every = [test for tests in agree.values() for test in tests]
    for what, hits in [("roughness", [r for r, _ in every]), ("friction", [f for _, f in every]), ("both", [all(both) for both in every])]:
        print(f"| {what} | {wilson(hits)} |")
    print("\n| | rank correlation: median, range |\n|---|---|")
    for what in panels[0]["spearman"]:
        ranks = [panel["spearman"][what] for panel in panels]
        print(f"| {what} | {median(ranks):.2f} ({min(ranks):.2f} to {max(ranks):.2f}) |")


if sys.argv[1:] == ["oracle"]:
    print("[\n" + ",\n".join(json.dumps(case) for case in oracle()) + "\n]")
elif sys.argv[1:] == ["check"]:
    sys.exit(check(json.load(sys.stdin)))
elif sys.argv[1:] == ["several"]:
    several(sys.stdin.read())
else:
    sys.exit(__doc__)
