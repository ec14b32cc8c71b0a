"""Mann-Whitney U by scipy (pinned in requirements.txt): what `hil texture panel` is held against.

    python panel.py oracle > hil/texture/src/panel/oracle.json    samples with many ties and few, and what scipy says
    hil texture panel --json | python panel.py check              every U and p of a panel computed again, to 1e-9
    cat PANELS.json | python panel.py several                     what panels of several seeds come to: how often display and
                                                                  finger agree (Wilson's intervals), and what goes with what
"""

import json
import sys

import numpy as np
from scipy.stats import mannwhitneyu


def scipys(a, b):
    found = mannwhitneyu(a, b, alternative="two-sided", method="asymptotic")
    return float(found.statistic), float(found.pvalue)


def oracle():
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


def wilson(hits, count, z=1.959964):
    share, spread = hits / count, z * z / count
    middle = (share + spread / 2) / (1 + spread)
    half = z * np.sqrt(share * (1 - share) / count + spread / (4 * count)) / (1 + spread)
    return f"{hits} of {count}: {share:.2f} ({middle - half:.2f} to {middle + half:.2f})"


def several(text):
    decoder, panels = json.JSONDecoder(), []
    while text := text.lstrip():
        panel, end = decoder.raw_decode(text)
        panels.append(panel)
        text = text[end:]
    agree = np.array([[[t["p"] >= 0.05 for t in texture["tests"]] for texture in panel["textures"]] for panel in panels])
    names = [texture["name"] for texture in panels[0]["textures"]]
    if len(names) <= 12:
        print("agrees, of", len(panels), "panels: roughness, friction, both; driven, median")
        for n, name in enumerate(names):
            driven = np.median([panel["textures"][n]["driven"] for panel in panels])
            print(f"  {name:<14}", *agree[:, n].sum(0), agree[:, n].all(1).sum(), f"{driven:.2f}")
    for what, hits in [("roughness", agree[:, :, 0]), ("friction", agree[:, :, 1]), ("both", agree.all(2))]:
        print(f"{what} agrees", wilson(int(hits.sum()), hits.size))
    for what in panels[0]["spearman"]:
        ranks = [panel["spearman"][what] for panel in panels]
        print(f"{what}: {np.median(ranks):.2f} ({min(ranks):.2f} to {max(ranks):.2f})")


if sys.argv[1:] == ["oracle"]:
    print("[\n" + ",\n".join(json.dumps(case) for case in oracle()) + "\n]")
elif sys.argv[1:] == ["check"]:
    sys.exit(check(json.load(sys.stdin)))
elif sys.argv[1:] == ["several"]:
    several(sys.stdin.read())
else:
    sys.exit(__doc__)
