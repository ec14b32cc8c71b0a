"""Files and textures as arrays."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
import pytest

import palpate

from hil import hil


def test_a_record_is_read_back(tmp_path: Path) -> None:
    run = palpate.run("sphere-along")
    for ending in ("csv", "jsonl", "log", "mcap"):
        run.save(tmp_path / f"run.{ending}")
    contacts = palpate.load(tmp_path / "run.csv")
    assert isinstance(contacts, palpate.Table)
    assert contacts.columns == run.contacts.columns
    for name in contacts.columns:
        np.testing.assert_allclose(contacts[name], run.contacts[name], atol=1e-9)
    stimuli = palpate.load(tmp_path / "run.jsonl")
    assert isinstance(stimuli, palpate.Table)
    own = run.stimuli[np.lexsort((run.stimuli["channel"], run.stimuli["board"], run.stimuli["time_us"]))]
    for name in ("time_us", "board", "channel", "width", "requested", "until_us", "pulses", "reason"):
        assert (stimuli[name] == own[name]).all(), name
    log, mcap = palpate.load(tmp_path / "run.log"), palpate.load(tmp_path / "run.mcap")
    assert isinstance(log, palpate.Table) and isinstance(mcap, palpate.Table)
    assert log.columns == ("time_us", "bus", "id", "data")
    assert len(log) > 10_000 and (log["data"] == mcap["data"]).all() and (log["id"] == mcap["id"]).all()


def test_taxels_are_read_as_they_replay(tmp_path: Path) -> None:
    path = tmp_path / "taxels.csv"
    hil("export", "taxels", "sphere-along", "--out", path)
    found = palpate.load(path, "uskin-4x4")
    assert isinstance(found, palpate.Recording)
    assert found.counts.shape == (len(found.time_us), 16, 3) and len(found.time_us) > 900
    by_array = palpate.run(replay=found.counts, time_us=found.time_us, layout="uskin-4x4")
    assert by_array.digests["schedule"] == palpate.run(replay=path, layout="uskin-4x4").digests["schedule"]
    listed = palpate.load([path], "uskin-4x4")
    assert isinstance(listed, list) and (listed[0].counts == found.counts).all()


def test_textures_are_encoded_as_the_program_does(tmp_path: Path) -> None:
    path = tmp_path / "taxels.csv"
    hil("export", "taxels", "sphere-along", "--out", path)
    with path.open() as file:
        header = file.readline().strip().split(",")
    every = np.loadtxt(path, delimiter=",", skiprows=1)
    rows = every[:, [header.index(name) for name in palpate.texture.features()]]
    text = hil("texture", "encode", "default", path)
    expected = np.array([[float(v) for v in line] for line in list(csv.reader(io.StringIO(text)))[1:]])
    found = palpate.texture.encode(rows)
    assert (found.rows == expected[:, 0]).all() and len(found.rows) > 900
    np.testing.assert_allclose(found.z, expected[:, 1:], atol=1e-6)
    grid = palpate.texture.encode(rows, soa_ms=50, rate_hz=100)
    assert 0 < len(grid.rows) < len(found.rows) / 3
    assert (grid.z == found.z[np.isin(found.rows, grid.rows)]).all()


def test_bad_files_say_what_was_expected(tmp_path: Path) -> None:
    (tmp_path / "other.txt").write_text("hello\n")
    for path, words in ((tmp_path / "other.txt", "taxels"), (tmp_path / "none.csv", "a file")):
        with pytest.raises(palpate.InputError, match=words):
            palpate.load(path)
    (tmp_path / "taxels.csv").write_text("time_us,txl1_x\n0,1\n")
    with pytest.raises(palpate.InputError, match="layout"):
        palpate.load(tmp_path / "taxels.csv")
    with pytest.raises(palpate.InputError, match="taxel columns") as error:
        palpate.load(tmp_path / "taxels.csv", "uskin-4x4")
    assert error.value.file == str(tmp_path / "taxels.csv")
    for readings, words in (
        (np.zeros((3, 45)), "one window"),
        (np.zeros((120, 7)), "features"),
        (np.full((120, 45), np.nan), "finite"),
    ):
        with pytest.raises(palpate.InputError, match=words):
            palpate.texture.encode(readings)
    with pytest.raises(palpate.InputError, match="both or neither"):
        palpate.texture.encode(np.zeros((120, 45)), soa_ms=5)
