"""Compression alone, against the program's own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import palpate

from hil import hil


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, npt.NDArray[np.uint64], npt.NDArray[np.uint16]]:
    path = tmp_path_factory.mktemp("recording") / "taxels.csv"
    hil("export", "taxels", "sphere-along", "--out", path)
    rows = np.loadtxt(path, delimiter=",", skiprows=1, dtype=np.uint64)
    return path, rows[:, 0], rows[:, 1:].astype(np.uint16)


@pytest.mark.parametrize(
    ("options", "settings"),
    [
        ([], {}),
        (["--kc", "2", "--ki", "5", "--norm", "l1"], {"kc": 2, "ki": 5, "norm": "l1"}),
        (["--kc", "2", "--vectors"], {"kc": 2, "vectors": True}),
        (
            ["--threshold", "per-taxel", "--drift-s", "10", "--axes", "z", "--reference-frames", "50"],
            {"threshold": "per-taxel", "drift_s": 10, "axes": "z", "reference_frames": 50},
        ),
        (
            ["--threshold", "40", "--weight-exponent", "2", "--replay-stale", "skip", "--seed", "9"],
            {"threshold": 40, "weight_exponent": 2, "skip_repeats": True, "seed": 9},
        ),
    ],
)
def test_contacts_are_those_of_the_program(
    recording: tuple[Path, npt.NDArray[np.uint64], npt.NDArray[np.uint16]],
    options: list[str],
    settings: dict[str, object],
) -> None:
    path, time_us, counts = recording
    lines = hil("contacts", path, "--layout", "uskin-4x4", *options).splitlines()
    found = palpate.contacts(counts, "uskin-4x4", time_us=time_us, **settings)  # type: ignore[arg-type]
    assert lines[0] == ",".join(found.columns)
    expected = [tuple(float(v) for v in line.split(",")) for line in lines[1:]]
    assert len(found) == len(expected) > 100
    np.testing.assert_allclose(np.array([tuple(row) for row in found], float), expected, atol=1e-9)


def test_an_array_on_disk_is_read_piece_by_piece(
    recording: tuple[Path, npt.NDArray[np.uint64], npt.NDArray[np.uint16]], tmp_path: Path
) -> None:
    _, time_us, counts = recording
    np.save(tmp_path / "counts.npy", np.tile(counts, (34, 1)).reshape(-1, 16, 3))
    mapped = np.load(tmp_path / "counts.npy", mmap_mode="r")
    assert len(mapped) > 2 * 16384
    found = palpate.contacts(mapped, "uskin-4x4", rate_hz=100)
    whole = palpate.contacts(np.array(mapped), "uskin-4x4", rate_hz=100)
    assert found.tobytes() == whole.tobytes() and found["frame"].max() > 2 * 16384


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"kc": 0}, "kc: expected 1 to 1024"),
        ({"norm": "l3"}, "norm"),
        ({"threshold": "big"}, "threshold"),
        ({"threshold": float("nan")}, "threshold"),
        ({"drift_s": float("nan")}, "drift_s"),
        ({"seed": -1}, "seed"),
        ({"layout": "thimble-8"}, "sensor"),
        ({"layout": "none-such"}, "none-such"),
        ({"rate_hz": None}, "rate_hz or time_us"),
        ({"counts": np.zeros((60, 15, 3), np.uint16)}, r"shape \(rows, 16, 3\)"),
        ({"counts": np.zeros((3, 16, 3), np.uint16)}, "at least 11 rows"),
        ({"counts": np.full((60, 16, 3), 0.25)}, "newtons"),
    ],
)
def test_bad_input_says_what_was_expected(arguments: dict[str, object], words: str) -> None:
    given: dict[str, object] = {"counts": np.zeros((60, 16, 3), np.uint16), "layout": "uskin-4x4", "rate_hz": 100}
    with pytest.raises(palpate.InputError, match=words):
        palpate.contacts(**(given | arguments))  # type: ignore[arg-type]
