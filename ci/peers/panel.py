"""Mann-Whitney U by scipy (pinned in requirements.txt): what `hil texture panel` is held against.

    python panel.py oracle > hil/texture/src/panel/oracle.json    samples with many ties and few, and what scipy says
    hil texture panel --json | python panel.py check              every U and p of a panel computed again, to 1e-9
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


if sys.argv[1:] == ["oracle"]:
    print("[\n" + ",\n".join(json.dumps(case) for case in oracle()) + "\n]")
elif sys.argv[1:] == ["check"]:
    sys.exit(check(json.load(sys.stdin)))
else:
    sys.exit(__doc__)
