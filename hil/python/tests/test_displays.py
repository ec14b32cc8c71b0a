"""Runs of several displays: each has tables of its own."""

from __future__ import annotations

import numpy as np
import pytest

import palpate

@pytest.fixture(scope="module")
def grasp() -> palpate.Run:
    return palpate.run("allegro-grasp", bench="allegro-hand")


def test_every_display_has_its_own_tables(grasp: palpate.Run) -> None:
    assert list(grasp.displays) == ["index", "middle", "ring", "thumb"]
    assert sum(len(d.stimuli) for d in grasp.displays.values()) == len(grasp.stimuli)
    assert sum(len(d.contacts) for d in grasp.displays.values()) == len(grasp.contacts)
    boards: dict[int, set[int]] = {}
    for number, (name, display) in enumerate(grasp.displays.items()):
        assert display.name == name
        felt = display.felt[display.felt["felt"]]
        assert len(felt) > 10
        error = np.hypot(felt["x_mm"] - felt["target_x_mm"], felt["y_mm"] - felt["target_y_mm"])
        # A gross check that places are this display's: the score itself leaves the first onsets out.
        assert np.median(error) < 2 * display.summary["felt"]["error_energy_mm"]["rmse"] + 0.5
        assert set(display.contacts["module"]) <= set(display.summary["modules"])
        assert display.summary["modules"][0] == 4 * number
        assert set(display.taxels["module"]) == set(display.summary["modules"])
        assert set(display.stimuli["wire"]) == set(range(8))
        assert set(display.temperatures["wire"]) == set(range(8))
        assert display.warmth["skin_c"].max() == pytest.approx(display.summary["hottest_skin_c"], abs=1e-9)
        assert "fingertip power, 60 s" in display.margins["name"]
        for board in set(display.stimuli["board"]):
            boards.setdefault(int(board), set()).update(display.stimuli["channel"][display.stimuli["board"] == board])
        assert "<html" in display.html() and name in repr(display)
    # Two displays of eight wires on either board.
    assert boards == {0: set(range(16)), 1: set(range(16))}


def test_the_runs_own_tables_say_whose_a_row_is(grasp: palpate.Run) -> None:
    for table in ("felt", "truth", "warmth"):
        rows = getattr(grasp, table)
        assert rows.columns[0] == "display"
        assert (np.diff(rows["time_us"].astype(np.int64)) >= 0).all()
        assert not rows.flags.writeable
        for name, display in grasp.displays.items():
            own = rows[rows["display"] == name]
            for column in getattr(display, table).columns:
                np.testing.assert_array_equal(own[column], getattr(display, table)[column])
    assert set(grasp.taxels["module"]) == set(range(15))
    assert len(grasp.taxels) == sum(len(d.taxels) for d in grasp.displays.values())
    assert "hand power, 60 s" in grasp.margins["name"]


def test_one_display_is_the_run() -> None:
    run = palpate.run("sphere-along", set={"length_s": 2.0})
    assert dict(run.displays) == {}
    assert run.felt.columns[0] == "time_us"
