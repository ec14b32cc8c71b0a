"""Tactile feedback with hardware in the loop: from a robot's touched skin to heated wires on a finger.

>>> import palpate
>>> run = palpate.run("sphere-along", seed=1)
>>> run.verdict
'ok'
>>> run.contacts["x_mm"].shape == run.contacts["y_mm"].shape
True
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ._palpate import VERSION as __version__

if TYPE_CHECKING:
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
    from ._run import Display, Run, run
    from ._sweep import RayExecutor, sweep
    from ._table import Table
else:
    # Names come from their modules when they are first used: numpy takes longer to load than the program to start.
    def __getattr__(name: str) -> object:
        """A public name, or a module of this package."""
        from importlib import import_module

        if name in _MODULES:
            return import_module(f"{__name__}.{name}")
        home = _HOMES.get(name)
        if home is None:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        found = globals()[name] = getattr(import_module(f"{__name__}.{home}"), name)
        return found

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})


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

_MODULES = ("emulators", "physics", "texture")
#: Where each public name is at home.
_HOMES = {
    "contacts": "_contacts",
    "BugError": "_errors",
    "BusyError": "_errors",
    "CheckError": "_errors",
    "DeviceError": "_errors",
    "Error": "_errors",
    "GuardError": "_errors",
    "InputError": "_errors",
    "Verdict": "_guard",
    "guard": "_guard",
    "Recording": "_load",
    "load": "_load",
    "Loop": "_loop",
    "Step": "_loop",
    "Display": "_run",
    "Run": "_run",
    "run": "_run",
    "RayExecutor": "_sweep",
    "sweep": "_sweep",
    "Table": "_table",
}
