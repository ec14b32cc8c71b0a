"""The guard, asked."""

from __future__ import annotations

import numpy as np
import pytest

import palpate


def test_what_a_run_applied_is_left_as_it_is() -> None:
    run = palpate.run("sphere-along")
    told = run.stimuli[run.stimuli["requested"] > 0]
    told = told[np.lexsort((told["wire"], told["time_us"]))]
    length = told["requested_until_us"] - told["time_us"]
    found = palpate.guard(told["time_us"], told["wire"], told["requested"], length)
    left = found.stimuli[np.lexsort((found.stimuli["wire"], found.stimuli["time_us"]))]
    assert len(left) == len(told) > 50
    assert (left["width"] == told["width"]).all() and (left["reason"] == told["reason"]).all()
    # The guard predicts from above what the emulated finger came to.
    assert run.summary["hottest_skin_c"] <= found.peak_c < 45
    assert 33 <= found.mean_c <= found.peak_c


def test_what_the_limits_do_not_bear_is_cut_with_a_reason() -> None:
    at = np.arange(200) * 117_000
    found = palpate.guard(at, 0, 4096, 38_000)
    assert (found.stimuli["requested"] == 4096).all()
    assert found.stimuli["width"].max() < 4096
    assert {"pulse-width"} <= set(found.stimuli["reason"]) - {""}
    still = palpate.guard([], [], [], [])
    assert len(still.stimuli) == 0 and still.omega == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (([0, 1], 0, 9, [1, 2, 3]), "as many of each"),
        (([5, 1], 0, 9, 100), "do not fall"),
        ((0, 8, 9, 100), "wire: expected 0 to 7"),
        ((0, 0, 5000, 100), "width: expected whole numbers from 0 to 4096"),
        ((0, 0, 0.5, 100), "width"),
        ((float("nan"), 0, 1, 100), "time_us"),
        (("now", 0, 1, 100), "time_us"),
    ],
)
def test_bad_input_says_what_was_expected(arguments: tuple[object, ...], words: str) -> None:
    with pytest.raises(palpate.InputError, match=words):
        palpate.guard(*arguments)  # type: ignore[arg-type]
