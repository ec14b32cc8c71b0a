"""The plug-in for pytest, in runs of pytest of its own."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest_plugins = ["pytester"]

SCENE = """\
name = "press"
description = "A sphere rests on the pad's middle"

[[touches]]
start_s = 0.8
path = { kind = "hold", points_mm = [[0.0, 0.0]] }
force_n = { mean = 0.7 }

[expect]
contacts_max = 1
"""


def write(pytester: pytest.Pytester, text: str = SCENE) -> Path:
    file = pytester.path / "press.scene.toml"
    file.write_text(text)
    return file


@pytest.fixture(autouse=True)
def loaded(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    # The wheel's entry point is the subject: no run names the plug-in.
    monkeypatch.delenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", raising=False)


def test_a_scene_is_a_test(pytester: pytest.Pytester) -> None:
    write(pytester)
    done = pytester.runpytest_subprocess("-v")
    done.assert_outcomes(passed=1)
    done.stdout.fnmatch_lines(["*press.scene.toml::press PASSED*"])
    assert not (pytester.path / "goldens").exists(), "only an update writes goldens"


def test_a_scene_on_motors_is_a_test_with_goldens(pytester: pytest.Pytester) -> None:
    write(pytester, SCENE.replace("\n[[touches]]", "wants = \"lra-8\"\n\n[[touches]]", 1))
    pytester.runpytest_subprocess("--palpate-update").assert_outcomes(passed=1)
    golden = pytester.path / "goldens/press.scene@lra-8.schedule.snap"
    assert "bench lra-8" in golden.read_text()
    pytester.runpytest_subprocess().assert_outcomes(passed=1)


def test_an_expectation_that_fails_is_a_failure_in_the_words_of_hil(pytester: pytest.Pytester) -> None:
    write(pytester, SCENE.replace("contacts_max = 1", "contacts_max = 0"))
    done = pytester.runpytest_subprocess()
    done.assert_outcomes(failed=1)
    done.stdout.fnmatch_lines(["FAILED*press*"])
    done.stdout.no_fnmatch_line("*Traceback*")


def test_goldens_are_snapshots(pytester: pytest.Pytester) -> None:
    write(pytester)
    pytester.runpytest_subprocess("--palpate-update").assert_outcomes(passed=1)
    golden = pytester.path / "goldens/press.scene.schedule.snap"
    kept = golden.read_text()
    pytester.runpytest_subprocess().assert_outcomes(passed=1)

    write(pytester, SCENE.replace("mean = 0.7", "mean = 0.9"))
    changed = pytester.runpytest_subprocess()
    changed.assert_outcomes(failed=1)
    changed.stdout.fnmatch_lines(["*press.scene.schedule.snap*", "*pytest --palpate-update*"])
    assert golden.read_text() == kept

    pytester.runpytest_subprocess("--palpate-update").assert_outcomes(passed=1)
    assert golden.read_text() != kept
    pytester.runpytest_subprocess().assert_outcomes(passed=1)


def test_an_update_keeps_no_golden_of_a_scene_that_fails(pytester: pytest.Pytester) -> None:
    write(pytester, SCENE.replace("contacts_max = 1", "contacts_max = 0"))
    pytester.runpytest_subprocess("--palpate-update").assert_outcomes(failed=1)
    assert not (pytester.path / "goldens").exists()


def test_a_mistake_in_a_scene_is_told_with_its_key(pytester: pytest.Pytester) -> None:
    write(pytester, SCENE.replace("start_s", "strat_s"))
    done = pytester.runpytest_subprocess()
    done.assert_outcomes(failed=1)
    done.stdout.fnmatch_lines(["*strat_s*"])


def test_other_files_are_left_alone(pytester: pytest.Pytester) -> None:
    (pytester.path / "press.toml").write_text(SCENE)
    pytester.makepyfile("def test_own(): pass")
    pytester.runpytest_subprocess().assert_outcomes(passed=1)
