"""The simulator's contacts are found where it has them."""

from __future__ import annotations

import importlib.util
import sys
from types import ModuleType

import numpy as np
import pytest

import palpate
from palpate.physics import Pad

from hil import root


def example(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, root() / "hil/python/examples" / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # where dataclasses look for the names of annotations
    spec.loader.exec_module(module)
    return module


def test_a_ball_of_mujoco_is_found_within_a_fifth_of_a_millimetre() -> None:
    pytest.importorskip("mujoco")
    ball = example("mujoco_ball")
    found, true = ball.roll()
    away = ball.error_mm(found, true)
    assert len(found) > 350
    assert np.ptp(true[:, 2]) > 8
    assert np.sqrt(np.mean(away**2)) < 0.2


def test_a_hand_of_mujoco_that_turns_a_box_is_felt_on_four_thimbles() -> None:
    pytest.importorskip("mujoco")
    hand = example("mujoco_hand")
    tips = hand.grasp()
    assert list(tips) == ["index", "middle", "ring", "thumb"]
    for tip in tips.values():
        away = hand.error_mm(tip)
        assert len(away) > 400
        assert np.sqrt(np.mean(away**2)) < 0.2
        true = np.array(tip.true)
        # The box turns: what is touched wanders over the skin.
        assert np.ptp(true[:, 2]) > 3
        felt = np.concatenate(tip.felt)
        assert felt["felt"].sum() > 30
        error = np.hypot(felt["x_mm"] - felt["target_x_mm"], felt["y_mm"] - felt["target_y_mm"])
        assert np.nanmedian(error) < 2
    # The thumb holds against three.
    force = {name: np.median(np.array(tip.true)[:, 3]) for name, tip in tips.items()}
    assert force["thumb"] == pytest.approx(sum(force[n] for n in ("index", "middle", "ring")), rel=0.1)


def test_a_pressure_field_of_drake_is_found_where_its_centre_is() -> None:
    pytest.importorskip("pydrake", reason="drake is not installed")
    ball = example("drake_ball")
    found, true, faces = ball.slide(1.0)
    away = ball.error_mm(found, true)
    assert len(found) > 80
    # A field, not a point, that goes along the pad with the force of the ball.
    assert faces > 30
    assert np.ptp(true[:, 2]) > 8
    assert np.ptp(true[20:, 3]) > 0.5
    assert np.sqrt(np.mean(away**2)) < 0.2


def test_presses_are_seen_from_the_pad() -> None:
    # A pad whose skin looks along the world's x, its right is the world's y.
    pad = Pad(origin_m=(1, 2, 3), rotation=[[0, 0, 1], [1, 0, 0], [0, 1, 0]])
    points = np.array([[1, 2.002, 2.996], [1, 2, 3], [1, 2, 3]])
    forces = np.array([[-0.7, 5, 0], [0.1, 0, 0], [0, 1, 1]])
    places, normal = pad.presses(points, forces)
    np.testing.assert_allclose(places, [[2, -4]], atol=1e-9)
    np.testing.assert_allclose(normal, [0.7])
    assert pad.presses([], [])[0].shape == (0, 2)
    for arguments, words in (
        (([[0, 0]], [[0, 0, 0]]), "points_m"),
        (([[0, 0, np.nan]], [[0, 0, 0]]), "points_m"),
        (([[0, 0, 0]], []), "one per point"),
    ):
        with pytest.raises(palpate.InputError, match=words):
            pad.presses(*arguments)
    with pytest.raises(palpate.InputError, match="rotation"):
        Pad((0, 0, 0), np.ones((3, 3))).presses([], [])
