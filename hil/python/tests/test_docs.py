"""The Python of the pages runs."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from hil import root


def blocks(page: Path) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize(("page", "least"), [("docs/python.md", 7), ("hil/python/README.md", 1)])
def test_every_block_runs(page: str, least: int, tmp_path: Path) -> None:
    found = blocks(root() / page)
    assert len(found) >= least
    for text in found:
        done = subprocess.run([sys.executable, "-c", text], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, f"{text}\n{done.stderr}"
