"""The plug-in for pytest: every file ``*.scene.toml`` is a test, and its goldens are the snapshots that it is held to."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from palpate import _program


class SceneFailure(Exception):
    """A trial that failed. Its text is what ``hil test`` says."""


class SceneItem(pytest.Item):
    """One scene, tried by ``hil test`` on the bench that ships with what the scene wants."""

    def runtest(self) -> None:
        """Tries the scene in a process of its own. A trial that ``hil`` skips or refuses is skipped."""
        with tempfile.TemporaryDirectory() as folder:
            junit = Path(folder) / "trial.xml"
            command = [sys.executable, _program.__file__, "test", str(self.path), "--junit", str(junit)]
            if self.config.getoption("palpate_update"):
                command.append("--accept")
            done = subprocess.run(command, capture_output=True, text=True, cwd=self.path.parent)
            if done.returncode != 0:
                raise SceneFailure(done.stdout + done.stderr)
            skipped = ElementTree.parse(junit).getroot().find(".//skipped")
        if skipped is not None:
            pytest.skip(skipped.get("message", ""))
        self.add_report_section("call", "hil", done.stdout)

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """The words of ``hil`` in place of a traceback."""
        if isinstance(excinfo.value, SceneFailure):
            return f"{excinfo.value}\nIf the change is wanted: pytest --palpate-update"
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int, str]:
        """The scene's file and name."""
        return self.path, 0, self.name


class SceneFile(pytest.File):
    """A file with one scene."""

    def collect(self) -> Iterator[SceneItem]:
        """The scene, named after the file."""
        yield SceneItem.from_parent(self, name=self.path.name.removesuffix(".scene.toml"))


def pytest_addoption(parser: pytest.Parser) -> None:
    """Adds ``--palpate-update``."""
    parser.getgroup("palpate").addoption(
        "--palpate-update",
        action="store_true",
        help="keep what scenes do now as their goldens, where they meet their expectations",
    )


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Takes every ``*.scene.toml``."""
    return SceneFile.from_parent(parent, path=file_path) if file_path.name.endswith(".scene.toml") else None
