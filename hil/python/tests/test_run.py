"""Runs: tables, digests, records, errors."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import palpate


@pytest.fixture(scope="module")
def rolled() -> palpate.Run:
    return palpate.run("sphere-along", seed=1)


def test_tables_agree_with_the_summary(rolled: palpate.Run) -> None:
    summary = rolled.summary
    assert rolled.verdict == "ok"
    assert len(rolled.contacts) == summary["contacts"]
    assert len(rolled.frames) == summary["frames"]
    assert int((rolled.stimuli["width"] > 0).sum()) == summary["stimuli"]
    assert (~rolled.felt["felt"] & rolled.felt["inside"]).sum() == summary["felt"]["breaks"]
    assert list(rolled.margins["name"]) == [m["name"] for m in summary["margins"]]
    assert rolled.warmth["skin_c"].max() == pytest.approx(summary["hottest_skin_c"], abs=1e-9)
    # Taxels are the display's module, frame by frame.
    taxels = rolled.taxels.reshape(len(rolled.frames), 16)
    assert (taxels["time_us"][:, 0] == rolled.frames["time_us"]).all()
    assert (taxels["change"].max(axis=1) == rolled.frames["peak_counts"]).all()


def test_a_scene_runs_on_the_bench_that_it_wants_and_on_no_bench_without_it() -> None:
    run = palpate.run("wifi-outage", set={"length_s": 2})
    assert run.summary["bench"] == "unit"
    with pytest.raises(palpate.InputError, match="wants"):
        palpate.run("wifi-outage", bench="emulated")


def test_what_is_not_felt_or_beside_the_pad_is_a_verdict() -> None:
    touch = {"start_s": 0.8, "path": {"kind": "hold", "points_mm": [[60.0, 0.0]]}, "force_n": {"mean": 0.5}}
    beside = palpate.run("sphere-along", set={"touches": [touch], "length_s": 2})
    assert beside.verdict == "off-the-pad"
    assert beside.summary["felt"]["breaks"] is None
    touch["path"] = {"kind": "hold", "points_mm": [[0.0, 0.0]]}
    touch["force_n"] = {"mean": 0.001}
    assert palpate.run("sphere-along", set={"touches": [touch], "length_s": 2}).verdict == "not-felt"


def test_contacts_follow_the_truth(rolled: palpate.Run) -> None:
    found, truth = rolled.contacts, rolled.truth
    at = {int(t): i for i, t in enumerate(truth["time_us"])}
    rows = [(c, truth[at[int(c["time_us"])]]) for c in found if int(c["time_us"]) in at]
    away = [np.hypot(c["x_mm"] - t["x_mm"], c["y_mm"] - t["y_mm"]) for c, t in rows]
    rmse = float(np.sqrt(np.mean(np.square(away))))
    assert rmse == pytest.approx(rolled.summary["path_error_mm"]["rmse"], abs=2e-3)


def test_a_run_is_the_same_in_every_thread(rolled: palpate.Run) -> None:
    found: list[dict[str, str]] = []
    work = lambda: found.append(palpate.run("sphere-along", seed=1).digests)  # noqa: E731
    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [rolled.digests] * 2
    assert palpate.run("sphere-along", seed=2).digests["trace"] != rolled.digests["trace"]


def test_values_in_place_of_the_files_own() -> None:
    run = palpate.run("sphere-along", set={"illusion.model": "balanced", "bench.drive.current_ma": 900})
    assert run.summary["contacts"] == palpate.run("sphere-along").summary["contacts"]
    assert run.digests["schedule"] != palpate.run("sphere-along").digests["schedule"]


def test_a_scene_as_text() -> None:
    text = """
name = "poke"
description = "One press in the middle"
layout = "uskin-4x4"
length_s = 1.5

[[touches]]
start_s = 0.8
end_s = 1.4
path = { kind = "hold", points_mm = [[0.0, 0.0]] }
diameter_mm = 8.0
force_n = { mean = 0.7 }
"""
    run = palpate.run(text)
    assert run.summary["scene"] == "poke"
    assert len(run.contacts) > 20


def test_an_array_replays_as_its_file_does(tmp_path: Path) -> None:
    rows, taxels = 300, 16
    counts = np.full((rows, taxels, 3), 30_000, dtype=np.uint16)
    counts[:, :, 2] += ((np.arange(rows)[:, None] + np.arange(taxels)) % 2).astype(np.uint16)
    counts[100:, 5, 2] += 600
    path = tmp_path / "press.csv"
    head = ",".join(f"txl{t + 1}_{axis}" for t in range(taxels) for axis in "xyz")
    np.savetxt(path, counts.reshape(rows, -1), delimiter=",", fmt="%d", header=head, comments="")
    by_array = palpate.run(replay=counts, layout="uskin-4x4", rate_hz=100)
    by_file = palpate.run(replay=path, layout="uskin-4x4", rate_hz=100)
    assert len(by_array.contacts) > 100
    assert by_array.digests["contacts"] == by_file.digests["contacts"]
    assert by_array.digests["schedule"] == by_file.digests["schedule"]
    timed = palpate.run(replay=counts, layout="uskin-4x4", time_us=np.arange(rows) * 10_000)
    assert timed.digests["schedule"] == by_array.digests["schedule"]


def test_records(rolled: palpate.Run, tmp_path: Path) -> None:
    for ending in ("mcap", "csv", "jsonl", "log", "vcd", "html", "json", "snap"):
        path = tmp_path / f"run.{ending}"
        rolled.save(path)
        assert path.stat().st_size > 1000, ending
    header = json.loads((tmp_path / "run.jsonl").read_text().splitlines()[0])
    assert header["seed"] == 1
    (tmp_path / "mine.csv").write_text("a,b\n1,2\n")
    with pytest.raises(palpate.InputError, match="--force replaces it"):
        rolled.save(tmp_path / "mine.csv")
    rolled.save(tmp_path / "mine.csv", force=True)
    with pytest.raises(palpate.InputError, match="expected a name that ends in"):
        rolled.save(tmp_path / "run.xyz")
    with pytest.raises(palpate.DeviceError) as error:
        rolled.save("/nonexistent/run.mcap")
    assert error.value.file == "/nonexistent/run.mcap"


def test_a_notebook_shows_the_report(rolled: palpate.Run) -> None:
    shown = rolled._repr_html_()
    assert shown.startswith("<iframe srcdoc=") and "sphere-along" in shown
    assert "sphere-along on emulated, seed 1: ok" in repr(rolled)


@pytest.mark.parametrize(
    ("arguments", "key", "words"),
    [
        ({"scene": "sphere-alon"}, None, "did you mean `sphere-along`"),
        ({"bench": "none-such"}, None, "none-such"),
        ({"set": {"illusion.modle": "inverse"}}, "illusion.modle", "modle"),
        ({"set": {"illusion.level_db": float("nan")}}, "illusion.level_db", "expected"),
        ({"set": {"a\n": 1}}, None, "expected"),
        ({"set": {"illusion.model": object()}}, None, "a number, a truth, a text"),
        ({"seed": -1}, None, "0 to 2"),
        ({"replay": "/nonexistent.csv", "layout": "uskin-4x4"}, None, "nonexistent.csv"),
        ({"replay": np.zeros((9, 15, 3), np.uint16), "layout": "uskin-4x4", "rate_hz": 100}, None, r"shape \(rows, 16, 3\)"),
        ({"replay": np.full((9, 16, 3), 0.7), "layout": "uskin-4x4", "rate_hz": 100}, None, "newtons"),
        ({"replay": np.full((9, 16, 3), np.nan), "layout": "uskin-4x4", "rate_hz": 100}, None, "NaN"),
        ({"replay": np.full((9, 16, 3), -4), "layout": "uskin-4x4", "rate_hz": 100}, None, "from -4 to -4"),
        ({"replay": np.full((9, 16, 3), "a"), "layout": "uskin-4x4", "rate_hz": 100}, None, "raw counts"),
        ({"replay": np.zeros((9, 16, 3), np.uint16), "layout": "uskin-4x4"}, None, "rate_hz or time_us"),
        ({"replay": np.zeros((9, 16, 3), np.uint16), "layout": "uskin-4x4", "rate_hz": 0.0}, None, "0.1 to 1e6"),
        ({"replay": np.zeros((9, 16, 3), np.uint16), "layout": "uskin-4x4", "rate_hz": 100}, None, "reference rows"),
        ({"replay": np.zeros((3, 16, 3), np.uint16), "layout": "uskin-4x4", "time_us": [0, 9, 5]}, None, "5 after 9 in row 2"),
        ({"replay": np.zeros((3, 16, 3), np.uint16), "layout": "uskin-4x4", "time_us": [0, 0.1, 0.2]}, None, "multiply seconds"),
    ],
)
def test_bad_input_says_what_was_expected(arguments: dict[str, object], key: str | None, words: str) -> None:
    with pytest.raises(palpate.InputError, match=words) as error:
        palpate.run(**arguments)  # type: ignore[arg-type]
    assert isinstance(error.value, ValueError)
    if key is not None:
        assert error.value.key == key
        assert error.value.hint


def test_an_error_keeps_its_parts_when_it_is_pickled() -> None:
    import pickle

    with pytest.raises(palpate.InputError) as error:
        palpate.run("sphere-along", set={"illusion.modle": 1})
    again = pickle.loads(pickle.dumps(error.value))
    assert (type(again), str(again), again.key) == (palpate.InputError, str(error.value), "illusion.modle")


def test_ctrl_c_ends_a_run() -> None:
    code = """
import signal, threading, palpate
print("begun", flush=True)
try:
    palpate.run("sphere-along", set={"length_s": 3600})
except KeyboardInterrupt:
    print("interrupted")
"""
    program = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert program.stdout is not None
    assert program.stdout.readline() == "begun\n"
    time.sleep(0.7)
    import signal

    program.send_signal(signal.SIGINT)
    assert program.communicate(timeout=20)[0] == "interrupted\n"


def test_importing_is_quick_and_has_every_name() -> None:
    code = "import time; t = time.perf_counter(); import palpate; print(time.perf_counter() - t)"
    took = min(float(subprocess.check_output([sys.executable, "-c", code])) for _ in range(5))
    assert took < 0.1
    for name in palpate.__all__:
        assert name in dir(palpate) and getattr(palpate, name) is not None
    assert not hasattr(palpate, "none_such")
