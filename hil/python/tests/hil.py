"""The program `hil` beside the wheel, which results are held against."""

from __future__ import annotations

import os
import subprocess

import pytest


def hil(*arguments: object) -> str:
    """What the program prints."""
    program = os.environ.get("PALPATE_HIL")
    if program is None:
        pytest.skip("PALPATE_HIL names no program to hold results against")
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout
