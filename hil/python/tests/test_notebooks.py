"""The notebooks run from top to bottom, and show what they say."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from hil import root

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

# Of each, how many pictures it draws, and words that its outputs have.
NOTEBOOKS: dict[str, tuple[int, list[str]]] = {
    "first-touch": (2, ["<iframe srcdoc=", "78 of 78 onsets are felt", "run.mcap"]),
    "your-recording": (2, ["mm RMSE along y", "newtons are no counts", "multiply seconds by 1e6"]),
    "wire-design": (1, ["designs;", "the strongest:", "felt_level_db"]),
    "mujoco-hand": (1, ["index", "thumb", "mm RMSE from MuJoCo's"]),
}


def shown(notebook: Any) -> tuple[str, int]:
    """All outputs as text, and how many pictures are among them."""
    texts, pictures = [], 0
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            assert output.output_type != "error", output
            texts.append(output.get("text", ""))
            data = output.get("data", {})
            texts += [data.get("text/html", ""), data.get("text/plain", "")]
            pictures += "image/png" in data
    return "\n".join(texts), pictures


def test_every_notebook_is_known() -> None:
    there = {path.stem for path in (root() / "hil/python/notebooks").glob("*.ipynb")}
    assert there == set(NOTEBOOKS)


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_runs_and_is_kept_without_its_outputs(name: str, tmp_path: Path) -> None:
    for package in ("matplotlib", "pandas", *(["mujoco"] if name == "mujoco-hand" else [])):
        pytest.importorskip(package)
    path = root() / "hil/python/notebooks" / f"{name}.ipynb"
    notebook = nbformat.read(path, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "commit notebooks without outputs"
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(path.parent)}}).execute()
    text, pictures = shown(notebook)
    pictured, words = NOTEBOOKS[name]
    assert pictures == pictured
    for word in words:
        assert word in text, word
    folder = os.environ.get("PALPATE_NOTEBOOKS")
    if folder is not None:
        nbformat.write(notebook, Path(folder) / f"{name}.ipynb")
