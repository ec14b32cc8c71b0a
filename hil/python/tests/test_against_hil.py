"""The same runs as the program's, to the byte."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import palpate

from hil import hil

TIMES = ("date", "wall_s", "frame_us")


@pytest.mark.parametrize(
    ("scene", "options", "settings"),
    [
        ("sphere-along", [], {}),
        ("two-finger-press", ["--bench", "thesis", "--seed", "5"], {"bench": "thesis", "seed": 5}),
        (
            "sphere-along",
            ["--set", "illusion.model=balanced", "--set", "bench.drive.current_ma=900", "--observe"],
            {"set": {"illusion.model": "balanced", "bench.drive.current_ma": 900}, "observe": True},
        ),
        ("ten-fingers", ["--bench", "ten-fingers"], {"bench": "ten-fingers"}),
    ],
)
def test_records_and_summary_are_the_programs(
    scene: str, options: list[str], settings: dict[str, object], tmp_path: Path
) -> None:
    endings = ("jsonl", "csv", "log") if scene == "ten-fingers" else ("jsonl", "csv", "log", "vcd", "mcap", "snap")
    (tmp_path / "a").mkdir()
    records = [word for e in endings for word in ("--record", tmp_path / "a" / f"run.{e}")]
    theirs = json.loads(hil("run", scene, *options, "--json", *records))
    run = palpate.run(scene, **settings)  # type: ignore[arg-type]
    assert {k: v for k, v in run.summary.items() if k not in TIMES} == {
        k: v for k, v in theirs.items() if k not in TIMES
    }
    (tmp_path / "b").mkdir()
    for ending in endings:
        run.save(tmp_path / "b" / f"run.{ending}")
        name = f"run.{ending}"
        assert (tmp_path / "b" / name).read_bytes() == (tmp_path / "a" / name).read_bytes(), ending


def test_a_recording_replays_as_the_program_replays_it(tmp_path: Path) -> None:
    for name in ("taxels.csv", "bus.log"):
        path = tmp_path / name
        if path.suffix == ".csv":
            hil("export", "taxels", "sphere-along", "--out", path)
        else:
            palpate.run("sphere-along").save(path)
        theirs = tmp_path / f"{name}.jsonl"
        hil("run", "--replay", path, "--layout", "uskin-4x4", "--schedule", theirs)
        run = palpate.run(replay=path, layout="uskin-4x4")
        run.save(tmp_path / f"{name}.own.jsonl")
        assert (tmp_path / f"{name}.own.jsonl").read_bytes() == theirs.read_bytes()
        assert run.summary["contacts"] > 100
