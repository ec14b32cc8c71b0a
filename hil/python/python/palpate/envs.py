"""Environments of Gymnasium for learned renderers. They need Gymnasium: ``palpate[gymnasium]``.

>>> import gymnasium
>>> import palpate.envs
>>> env = gymnasium.make("palpate/Felt-v0")
"""

from __future__ import annotations

from typing import Any, Literal

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from ._errors import DeviceError, GuardError, InputError
from ._loop import Loop
from ._setup import Name
from ._table import table

__all__ = ["Felt"]

# Counts have 16 bits on each of three axes.
_MOST = 65_535.0 * np.sqrt(3.0)
# The hand moves every scan of 100 Hz.
_PIECE_US = 10_000
# What the environment looks at lies just before an onset, so that the action is for that onset.
_BEFORE_US = 1_000

# Activations are taken as they are: an intensity of the contact would weight them. The cadence leaves the guard little
# to limit at full drive.
_OWN: dict[str, object] = {
    "illusion.model": "balanced",
    "illusion.intensity": False,
    "illusion.tau_d_ms": 38.0,
    "illusion.soa_ms": 117.0,
}

Array = npt.NDArray[np.float32]


class Felt(gymnasium.Env[Array, Array]):
    """A round object slides over the skin, and a renderer chooses the activations of the wires.

    A step is one onset, 117 ms by default. Drive, guard, chip, amplifier, wires, tissue and person are emulated as in
    every run, so an action that the guard limits is felt as far as the guard lets it.

    Observation: how far every taxel is from its reference when the onset is due, counts, shape (taxels,). A taxel that is
    left out as faulty is 0.

    Action: the activation of every wire at that onset, 0 to 1, shape (wires,). With ``action="pulses"`` also how many
    pulses its burst has, 0 for one to 1 for the most that fit: shape (2, wires), activations first.

    Reward: minus the distance from where the touch is to where it is felt, mm, minus ``heat_mm_per_c`` for every degree
    of the hottest skin over its temperature at the start. What is not felt is as far away as the display is large.

    An episode is truncated after ``steps``. It terminates where the guard, or a bus, ends the loop.

    ``info`` of a step: ``felt`` (whether), ``felt_mm`` (place, NaN where no wire moved), ``target_mm`` (where the touch
    is), ``error_mm``, ``level_db`` (over threshold), ``skin_c`` (hottest), ``limited`` (stimuli that the guard changed).

    Args:
        layout: The skin, of one module.
        bench: The emulated bench whose display is worn.
        set: Values in place of the files' own, such as ``{"bench.drive.current_ma": 900}``.
        steps: Onsets of an episode.
        heat_mm_per_c: What a degree costs, mm.
        action: ``"activations"``, or ``"pulses"`` for a pulse pattern.
        reach_mm: The touch stays in this distance of the module's middle, along x and along y.
    """

    metadata = {"render_modes": []}  # noqa: RUF012 (declared so by Gymnasium)

    def __init__(
        self,
        layout: Name = "uskin-4x4",
        bench: Name | None = None,
        *,
        set: dict[str, object] | None = None,
        steps: int = 60,
        heat_mm_per_c: float = 0.1,
        reach_mm: float = 4.0,
        action: Literal["activations", "pulses"] = "activations",
    ) -> None:
        if action not in ("activations", "pulses"):
            raise InputError.of("action", '"activations" or "pulses"', repr(action))
        for name, value, least in (
            ("steps", steps, 1),
            ("heat_mm_per_c", heat_mm_per_c, 0),
            ("reach_mm", reach_mm, 0),
        ):
            if not least <= value < 1e6:
                raise InputError.of(name, f"{least} to 1e6", repr(value))
        self._made: dict[str, Any] = {"layout": layout, "bench": bench, "set": _OWN | (set or {})}
        self._steps, self._heat, self._reach = steps, heat_mm_per_c, reach_mm
        #: The loop of the episode: it says where taxels and wires lie.
        self.loop = loop = self._new(0)
        if len(loop.shapes) != 1:
            raise InputError.of("layout", "a skin of one module", f"{len(loop.shapes)} modules")
        wires = loop.wires
        corners = [np.ptp(wires["x_mm"]), np.ptp(wires["y_mm"])]
        self._size_mm = float(np.hypot(*corners))
        self.observation_space = spaces.Box(0.0, _MOST, (loop.shapes[0][0],), np.float32)
        shape = (len(wires),) if action == "activations" else (2, len(wires))
        self.action_space = spaces.Box(0.0, 1.0, shape, np.float32)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """A new skin, a new person's finger at rest, and another touch."""
        super().reset(seed=seed)
        random = self.np_random
        self.loop.close()
        loop = self.loop = self._new(int(random.integers(2**32)))
        # A path that never stands still, with frequencies of a hand.
        self._hz = random.uniform(0.05, 0.3, 2)
        self._phase = random.uniform(0.0, 2 * np.pi, 2)
        self._force_n = float(random.uniform(0.5, 1.0))
        self._diameter_mm = float(random.uniform(10.0, 30.0))
        self._done = 0
        soa = loop.soa_us
        # The reference, half a second of it, and some scans of the touch.
        self._onset = -(-1_000_000 // soa)
        loop.advance(self._onset * soa - 250_000)
        self._rest_c = float(loop.temperatures()["skin_c"].max())
        self._press_until(self._onset * soa - _BEFORE_US)
        loop._inner.conclude()
        return self._observation(), {"target_mm": self._target_on_skin()}

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Plays the onset that is due, and advances to just before the next."""
        loop = self.loop
        activations, *parts = np.clip(action, 0.0, 1.0).reshape(-1, len(loop.wires))
        more = loop.most_pulses - 1
        loop.activate(activations, *(1 + np.rint(part * more).astype(np.int64) for part in parts))
        self._done += 1
        self._onset += 1
        ended = False
        try:
            limited = self._press_until(self._onset * loop.soa_us - _BEFORE_US)
        except (GuardError, DeviceError):
            ended, limited = True, 0
        info, reward = self._reward(limited, ended)
        return self._observation(), reward, ended, self._done >= self._steps, info

    def close(self) -> None:
        """Frees the environment."""
        self.loop.close()

    def _new(self, seed: int) -> Loop:
        return Loop(**self._made, seed=seed, skin="emulated", illusion="own")

    def _target_on_skin(self) -> npt.NDArray[np.float64]:
        t = self.loop.time_us * 1e-6
        place: npt.NDArray[np.float64] = self._reach * np.sin(2 * np.pi * self._hz * t + self._phase)
        return place

    def _press_until(self, until_us: int) -> int:
        """Slides the hand on. Returns the number of stimuli that the guard changed meanwhile."""
        loop, limited = self.loop, 0
        while loop.time_us < until_us:
            loop.touch(self._target_on_skin(), [self._force_n], diameter_mm=self._diameter_mm)
            step = loop.advance(min(loop.time_us + _PIECE_US, until_us))
            limited += int((step.stimuli["reason"] != "").sum())
        return limited

    def _observation(self) -> Array:
        changes = np.frombuffer(self.loop._inner.changes(), np.float32)
        if changes.size == 0:
            return np.zeros(self.observation_space.shape or (), np.float32)
        return np.nan_to_num(changes, nan=0.0)

    def _reward(self, limited: int, ended: bool) -> tuple[dict[str, Any], float]:
        felt = table(self.loop._inner.conclude().table("felt"))
        skin_c = float(self.loop.temperatures()["skin_c"].max())
        nowhere = np.full(2, np.nan)
        info: dict[str, Any] = {
            "felt": False,
            "felt_mm": nowhere,
            "target_mm": nowhere,
            "error_mm": self._size_mm,
            "level_db": -np.inf,
            "skin_c": skin_c,
            "limited": limited,
        }
        if len(felt):
            row = felt[-1]
            info["felt"] = bool(row["felt"])
            info["felt_mm"] = np.array([row["x_mm"], row["y_mm"]])
            info["target_mm"] = np.array([row["target_x_mm"], row["target_y_mm"]])
            info["level_db"] = float(row["level_db"])
            if info["felt"]:
                away = info["felt_mm"] - info["target_mm"]
                info["error_mm"] = min(float(np.hypot(*away)), self._size_mm)
        return info, -info["error_mm"] - self._heat * max(skin_c - self._rest_c, 0.0)


gymnasium.register("palpate/Felt-v0", entry_point="palpate.envs:Felt")
