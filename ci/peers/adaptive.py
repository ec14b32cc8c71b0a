"""Answers and the levels that published methods ask for after each: QUEST+ by questplus, staircases by PsychoPy.

Writes the vectors that the tests of palpate-study hold their own methods against, trial by trial:

    pip install questplus==2023.1 six i18next && pip install --no-deps psychopy==2026.2.5
    python ci/peers/adaptive.py hil/study/src/adaptive.json
"""

import json
import sys

import numpy as np
from psychopy.data.staircase import StairHandler
from questplus import QuestPlus

TRIALS = 60


def answers(level, random, threshold):
    """Whether a person with this threshold answers correctly."""
    p = 0.98 - 0.48 * np.exp(-(10 ** (3.5 * (level - threshold) / 20)))
    return bool(random.random() < p)


def quest(seed):
    """A session of QUEST+."""
    random = np.random.default_rng(seed)
    threshold = random.uniform(-30, -5)
    domain = {
        "threshold": np.arange(-40, 0.5, 0.5),
        "slope": [2.0, 3.5, 5.0],
        "lower_asymptote": [0.5],
        "lapse_rate": [0.02],
    }
    method = QuestPlus(
        stim_domain={"intensity": np.arange(-40.0, 1.0)},
        param_domain=domain,
        outcome_domain={"response": ["correct", "wrong"]},
        func="weibull",
        stim_scale="dB",
        stim_selection_method="min_entropy",
        param_estimation_method="mean",
    )
    session = {"levels": [], "correct": [], "thresholds": []}
    for _ in range(TRIALS):
        level = float(method.next_stim["intensity"])
        correct = answers(level, random, threshold)
        method.update(
            stim={"intensity": level},
            outcome={"response": "correct" if correct else "wrong"},
        )
        session["levels"].append(level)
        session["correct"].append(correct)
        session["thresholds"].append(float(method.param_estimate["threshold"]))
    return session


def staircase(seed):
    """A staircase, one up and two down."""
    random = np.random.default_rng(seed)
    threshold = random.uniform(-30, -5)
    method = StairHandler(
        startVal=0,
        nReversals=12,
        stepSizes=[8, 4, 2],
        stepType="lin",
        nTrials=1,
        nUp=1,
        nDown=2,
        minVal=-40,
        maxVal=0,
    )
    session = {"levels": [], "correct": []}
    for level in method:
        correct = answers(level, random, threshold)
        session["levels"].append(float(level))
        session["correct"].append(correct)
        method.addResponse(int(correct))
    session["turns"] = [float(level) for level in method.reversalIntensities]
    return session


vectors = {
    "quest": [quest(seed) for seed in range(6)],
    "staircase": [staircase(seed) for seed in range(20)],
}
with open(sys.argv[1], "w", encoding="utf-8") as out:
    json.dump(vectors, out)
    out.write("\n")
