"""What the wheel is held against: the program `hil`, and the pages and examples of the checkout."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest


def hil(*arguments: object) -> str:
    """What the program prints."""
    program = os.environ.get("PALPATE_HIL")
    if program is None:
        pytest.skip("PALPATE_HIL names no program to hold results against")
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def root() -> Path:
    """The checkout."""
    found = os.environ.get("PALPATE_ROOT")
    if found is None:
        pytest.skip("PALPATE_ROOT names no checkout, whose pages and examples are used")
    return Path(found)
