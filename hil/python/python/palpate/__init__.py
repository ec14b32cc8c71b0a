"""Tactile feedback with hardware in the loop: from a robot's touched skin to heated wires on a finger.

>>> import palpate
>>> run = palpate.run("sphere-along", seed=1)
>>> run.verdict
'ok'
>>> run.contacts["x_mm"].shape == run.contacts["y_mm"].shape
True
"""

from . import emulators, physics, texture
from ._contacts import contacts
from ._errors import (
    BugError,
    BusyError,
    CheckError,
    DeviceError,
    Error,
    GuardError,
    InputError,
)
from ._guard import Verdict, guard
from ._load import Recording, load
from ._loop import Loop, Step
from ._palpate import VERSION as __version__
from ._run import Display, Run, run
from ._sweep import RayExecutor, sweep
from ._table import Table

__all__ = [
    "BugError",
    "BusyError",
    "CheckError",
    "DeviceError",
    "Display",
    "Error",
    "GuardError",
    "InputError",
    "Loop",
    "RayExecutor",
    "Recording",
    "Run",
    "Step",
    "Table",
    "Verdict",
    "__version__",
    "contacts",
    "emulators",
    "guard",
    "load",
    "physics",
    "run",
    "sweep",
    "texture",
]
