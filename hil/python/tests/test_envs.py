"""The environment that renderers are learned in."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import palpate
from palpate import Loop

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

from palpate.envs import Felt  # noqa: E402


def episode(env: Any, policy: Any, seed: int) -> tuple[float, list[dict[str, Any]]]:
    observation, _ = env.reset(seed=seed)
    total, infos, over = 0.0, [], False
    while not over:
        observation, reward, terminated, truncated, info = env.step(policy(observation))
        assert not terminated
        total, over = total + reward, truncated
        infos.append(info)
    return total, infos


def between(env: Felt) -> Any:
    """Activates the three wires that are nearest to the middle of the taxels that are pressed."""
    wires, taxels = (np.stack([t["x_mm"], t["y_mm"]], axis=1) for t in (env.loop.wires, env.loop.taxels))
    # Each taxel where the skin, laid over the display, has it.
    parts = (taxels - taxels.min(axis=0)) / np.ptp(taxels, axis=0)
    at = wires.min(axis=0) + parts * np.ptp(wires, axis=0)

    def policy(observation: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        weights = observation.astype(np.float64) ** 2
        if weights.sum() == 0:
            return np.zeros(len(wires), np.float32)
        place = weights @ at / weights.sum()
        away = np.hypot(*(wires - place).T)
        near = np.where(away <= np.sort(away)[2], np.sqrt(np.clip(1 - away / 14.0, 0, 1)), 0)
        # Three tenths of full drive are felt, and the guard lets three wires have them all the time.
        made: np.ndarray[Any, Any] = (0.3 * near / near.max()).astype(np.float32)
        return made

    return policy


def test_gymnasium_finds_and_accepts_it() -> None:
    env = gymnasium.make("palpate/Felt-v0", steps=5)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # A reward that depends on heat falls below any bound that could be stated.
        check_env(env.unwrapped, skip_render_check=True)
    env.close()


def test_pulse_patterns_are_an_action() -> None:
    env = gymnasium.make("palpate/Felt-v0", steps=5, action="pulses")
    assert env.action_space.shape == (2, 8)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True)
    env.close()
    levels = []
    for part in (0.0, 0.5, 1.0):
        made = np.stack([np.full(8, 0.2), np.full(8, part)]).astype(np.float32)
        _, infos = episode(Felt(steps=5, action="pulses"), lambda _, made=made: made, 5)
        levels.append([info["level_db"] for info in infos])
    few, some, most = (float(np.median(level)) for level in levels)
    assert few < some < most
    # An action without pulses gives as many, but for the half period by which a counted burst is shorter.
    _, infos = episode(Felt(steps=5), lambda _: np.full(8, 0.2, np.float32), 5)
    whole = float(np.median([info["level_db"] for info in infos]))
    assert abs(whole - most) < 1 < most - some


def test_the_same_seed_is_the_same_episode() -> None:
    env = Felt(steps=8)
    ones = lambda _: np.ones(8, np.float32)  # noqa: E731
    first, again, other = (episode(env, ones, seed) for seed in (3, 3, 4))
    assert first[0] == again[0] != other[0]


def test_a_renderer_that_looks_is_better_than_none_and_than_chance() -> None:
    env = Felt(steps=30)
    random = np.random.default_rng(1)
    looking, infos = episode(env, between(env), 7)
    chance, _ = episode(env, lambda _: random.uniform(0, 1, 8).astype(np.float32), 7)
    nothing, dark = episode(env, lambda _: np.zeros(8, np.float32), 7)
    assert nothing < chance < looking
    assert not any(info["felt"] for info in dark)
    felt = [info["error_mm"] for info in infos if info["felt"]]
    assert len(felt) > 25 and np.median(felt) < 2.5
    assert not any(info["limited"] for info in infos)
    # What is felt was where the touch was, in a place that moved.
    assert np.ptp([info["target_mm"] for info in infos], axis=0).max() > 2.0
    assert max(info["skin_c"] for info in infos) > dark[-1]["skin_c"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"layout": "allegro"}, "one module"),
        ({"steps": 0}, "steps"),
        ({"action": "widths"}, "action"),
        ({"reach_mm": float("nan")}, "reach_mm"),
        ({"heat_mm_per_c": -1.0}, "heat_mm_per_c"),
    ],
)
def test_bad_input_says_what_was_expected(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(palpate.InputError, match=words):
        Felt(**arguments)


def test_activations_are_checked() -> None:
    own = {"illusion.model": "balanced"}
    with Loop("uskin-4x4", set=own, skin="emulated", illusion="own") as loop:
        for values in ([0.5] * 7, [2.0] * 8, [-0.1] * 8, [np.nan] * 8, [[0.5] * 8]):
            with pytest.raises(palpate.InputError, match="activations"):
                loop.activate(values)
        for pulses in ([1] * 7, [0] * 8, [8] * 8, [1.5] * 8, 3):
            with pytest.raises(palpate.InputError, match="pulses"):
                loop.activate([0.5] * 8, pulses)
    with pytest.raises(palpate.InputError, match="balanced"):
        Loop("uskin-4x4", skin="emulated", illusion="own")
    with pytest.raises(palpate.InputError, match="skin"):
        Loop("uskin-4x4", set=own, illusion="own")
    with pytest.raises(palpate.InputError, match="own"):
        Loop("uskin-4x4", skin="emulated").activate([0.5] * 8)
