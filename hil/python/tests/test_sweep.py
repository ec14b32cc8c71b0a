"""Sweeps: the same table whatever runs it, and after any death."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import palpate

from hil import hil

GRID: dict[str, Any] = {"illusion.model": ["balanced", "inverse"], "bench.drive.current_ma": [900, 1200], "seed": range(1, 6)}


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> tuple[palpate.Table, bytes]:
    out = tmp_path_factory.mktemp("sweep") / "runs.jsonl"
    return palpate.sweep("sphere-along", GRID, out=out, batch=2), out.read_bytes()


def test_a_row_per_run_in_the_order_of_the_grid(swept: tuple[palpate.Table, bytes]) -> None:
    table, _ = swept
    assert len(table) == 20
    assert list(table["seed"][:6]) == [1, 2, 3, 4, 5, 1]
    assert list(table["illusion.model"][[0, 10]]) == ["balanced", "inverse"]
    assert set(table["bench.drive.current_ma"]) == {900.0, 1200.0}
    one = palpate.run("sphere-along", seed=2, set={"illusion.model": "balanced", "bench.drive.current_ma": 900})
    assert table["contacts"][1] == one.summary["contacts"]
    assert table["energy_mj"][1] == pytest.approx(one.summary["energy_mj"], abs=1e-9)
    assert np.isnan(table["roughness"]).all()


def test_the_program_writes_the_same_bytes(swept: tuple[palpate.Table, bytes], tmp_path: Path) -> None:
    out = tmp_path / "runs.jsonl"
    hil("sweep", "sphere-along", "--set", "illusion.model=balanced,inverse", "--set", "bench.drive.current_ma=900,1200",
        "--seeds", "1..5", "--out", out, "--quiet")
    assert out.read_bytes() == swept[1]
    table = palpate.sweep("sphere-along", GRID, out=tmp_path / "runs.csv", batch=7)
    hil("sweep", "sphere-along", "--set", "illusion.model=balanced,inverse", "--set", "bench.drive.current_ma=900,1200",
        "--seeds", "1..5", "--out", tmp_path / "theirs.csv", "--quiet")
    assert (tmp_path / "runs.csv").read_bytes() == (tmp_path / "theirs.csv").read_bytes()
    assert table.tobytes() == swept[0].tobytes()


def test_processes_give_the_same_bytes(swept: tuple[palpate.Table, bytes], tmp_path: Path) -> None:
    out = tmp_path / "runs.jsonl"
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        palpate.sweep("sphere-along", GRID, executor=pool, out=out, batch=3)
    assert out.read_bytes() == swept[1]


def test_a_table_that_is_there_is_not_computed_again(swept: tuple[palpate.Table, bytes], tmp_path: Path) -> None:
    class Refusing:
        def submit(self, fn: Any, /, *args: Any) -> Future[Any]:
            raise AssertionError("nothing is lacking")

    out = tmp_path / "runs.jsonl"
    out.write_bytes(swept[1])
    palpate.sweep("sphere-along", GRID, executor=Refusing(), out=out)
    # Half a table, its last line cut off: as a death leaves it.
    lines = swept[1].splitlines(keepends=True)
    out.write_bytes(b"".join(lines[7:15]) + lines[3][:40])
    palpate.sweep("sphere-along", GRID, out=out)
    assert out.read_bytes() == swept[1]
    with pytest.raises(palpate.InputError, match="of another"):
        palpate.sweep("sphere-along", {"seed": [1]}, out=out)


def test_a_sweep_whose_driver_died_goes_on(tmp_path: Path) -> None:
    code = f"""
import palpate
palpate.sweep("sphere-along", {{"seed": range(1, 201)}}, out={str(tmp_path / "runs.jsonl")!r}, batch=2)
"""
    out = tmp_path / "runs.jsonl"
    driver = subprocess.Popen([sys.executable, "-c", code])
    while not out.exists() or out.read_bytes().count(b"\n") < 6:
        time.sleep(0.02)
        assert driver.poll() is None
    os.kill(driver.pid, signal.SIGKILL)
    driver.wait()
    there = out.read_bytes().count(b"\n")
    assert 6 <= there < 200
    table = palpate.sweep("sphere-along", {"seed": range(1, 201)}, out=out)
    assert len(table) == 200 and list(table["seed"]) == list(range(1, 201))
    whole = tmp_path / "whole.jsonl"
    palpate.sweep("sphere-along", {"seed": range(1, 201)}, out=whole)
    assert out.read_bytes() == whole.read_bytes()


def test_ctrl_c_ends_a_sweep_and_keeps_its_rows(tmp_path: Path) -> None:
    out = tmp_path / "runs.jsonl"
    code = f"""
import palpate
try:
    palpate.sweep("sphere-along", {{"seed": range(1, 2001)}}, out={str(out)!r})
except KeyboardInterrupt:
    print("interrupted")
"""
    driver = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    while not out.exists() or out.read_bytes().count(b"\n") < 6:
        time.sleep(0.02)
    driver.send_signal(signal.SIGINT)
    assert driver.communicate(timeout=30)[0] == "interrupted\n"
    assert 6 <= out.read_bytes().count(b"\n") < 2000


def test_a_worker_of_another_version_is_refused(tmp_path: Path) -> None:
    class Other:
        def submit(self, fn: Any, /, *args: Any) -> Future[Any]:
            future: Future[Any] = Future()
            version = f'"version":"{palpate.__version__}"'
            future.set_result([row.replace(version, '"version":"0.0.1"') for row in fn(*args)])
            return future

    with pytest.raises(palpate.InputError, match=r"expected palpate .*, found palpate 0.0.1"):
        palpate.sweep("sphere-along", {"seed": [1]}, executor=Other(), out=tmp_path / "runs.jsonl")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"grid": {"illusion.modle": [1]}}, "modle"),
        ({"grid": {"illusion.alpha": []}}, "1 to 10000000 runs"),
        ({"grid": {"seed": [1, 1]}}, "again"),
        ({"grid": {"seed": [-1]}}, "seed"),
        ({"batch": 0}, "batch"),
        ({"out": "runs.txt"}, "csv or .jsonl"),
        ({"scene": "none-such"}, "none-such"),
    ],
)
def test_bad_input_says_what_was_expected(arguments: dict[str, object], words: str, tmp_path: Path) -> None:
    given: dict[str, object] = {"scene": "sphere-along", "grid": {"seed": [1]}, "out": tmp_path / "runs.jsonl"}
    with pytest.raises(palpate.InputError, match=words):
        palpate.sweep(**(given | arguments))  # type: ignore[arg-type]
