"""The same runs as the program's, to the byte."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import palpate

from hil import hil, root

TIMES = ("date", "wall_s", "frame_us")


@pytest.mark.parametrize(
    ("scene", "options", "settings"),
    [
        ("sphere-along", [], {}),
        ("two-finger-press", ["--bench", "thesis", "--seed", "5"], {"bench": "thesis", "seed": 5}),
        (
            "sphere-along",
            ["--set", "illusion.model=balanced", "--set", "bench.drive.current_ma=820", "--observe"],
            {"set": {"illusion.model": "balanced", "bench.drive.current_ma": 820}, "observe": True},
        ),
        ("ten-fingers", ["--bench", "ten-fingers"], {"bench": "ten-fingers"}),
        ("sphere-along", ["--bench", "lra-8"], {"bench": "lra-8"}),
        ("coils-circle", [], {}),
        ("back-circle", [], {}),
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


def test_a_bench_of_hardware_is_refused(tmp_path: Path) -> None:
    page = (root() / "docs/bench.md").read_text()
    blocks = [block.split("```")[0] for block in page.split("```toml\n")[1:]]
    bench = tmp_path / "my-bench.toml"
    text = next(block for block in blocks if 'kind = "real"' in block)
    # The page shows the first of its eight outputs.
    more = "".join(f"[[outputs]]\nbus = 0\nboard = 0x40\nchannel = {n}\n" for n in range(1, 8))
    bench.write_text(text + more)
    for work in (
        lambda: palpate.run("sphere-along", bench=bench),
        lambda: palpate.Loop("uskin-4x4", bench),
        lambda: palpate.sweep("sphere-along", {"seed": [1]}, bench=bench, out=tmp_path / "runs.jsonl"),
    ):
        with pytest.raises(palpate.InputError, match="only the program `hil` opens hardware"):
            work()
