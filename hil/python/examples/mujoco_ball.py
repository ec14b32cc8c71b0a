"""A ball that MuJoCo presses and rolls over the skin, felt on the emulated thimble.

    pip install palpate mujoco
    python mujoco_ball.py

Contact forces go through Palpate's own silicone. MuJoCo's tactile sensors are no taxels: the depth that they report
depends on the mass of the ball.
"""

from __future__ import annotations

import mujoco
import numpy as np

import palpate
from palpate.physics import Pad, mujoco_contacts

DIAMETER_MM = 19.45
# The pad's surface is the plane z = 0; the ball is held along y and pressed down.
WORLD = f"""
<mujoco>
  <option timestep="0.0005"/>
  <worldbody>
    <geom name="pad" type="box" size="0.012 0.012 0.005" pos="0 0 -0.005"/>
    <body name="ball" pos="0 0 {DIAMETER_MM / 2000}">
      <joint name="x" type="slide" axis="1 0 0" stiffness="200" damping="2"/>
      <joint name="y" type="slide" axis="0 1 0"/>
      <joint name="z" type="slide" axis="0 0 1"/>
      <joint name="roll" type="ball"/>
      <geom name="ball" type="sphere" size="{DIAMETER_MM / 2000}" mass="0.03"/>
    </body>
  </worldbody>
  <actuator>
    <position name="along" joint="y" kp="200" kv="4"/>
    <motor name="down" joint="z" gear="-1"/>
  </actuator>
</mujoco>
"""


def roll(seconds: float = 4.0) -> tuple[palpate.Table, np.ndarray]:
    """What the loop finds, and MuJoCo's own contact places: rows of time (us), x and y (mm)."""
    model = mujoco.MjModel.from_xml_string(WORLD)
    data = mujoco.MjData(model)
    skin = model.geom("pad").id
    pad = Pad(origin_m=(0, 0, 0))
    loop = palpate.Loop("uskin-4x4", skin="emulated")
    found, true = [], []
    begin_us, step_us = 700_000, 2_000
    loop.advance(begin_us)
    for step in range(int(seconds * 1e6) // step_us):
        t = step * step_us * 1e-6
        data.ctrl[0] = 0.005 * np.sin(2 * np.pi * t / seconds)
        data.ctrl[1] = 0.4 + 0.3 * (1 - np.cos(2 * np.pi * t / seconds))
        for _ in range(4):
            mujoco.mj_step(model, data)
        places, forces = pad.presses(*mujoco_contacts(model, data, skin))
        loop.touch(places, forces, diameter_mm=DIAMETER_MM)
        now_us = begin_us + (step + 1) * step_us
        found.append(loop.advance(now_us).contacts)
        if len(places) == 1:
            true.append((now_us, *places[0]))
    every = np.concatenate(found)
    return every.view(palpate.Table), np.array(true)


def error_mm(found: palpate.Table, true: np.ndarray) -> np.ndarray:
    """How far each contact that was found is from MuJoCo's at its time, mm."""
    at = found["time_us"]
    x = np.interp(at, true[:, 0], true[:, 1])
    y = np.interp(at, true[:, 0], true[:, 2])
    away: np.ndarray = np.hypot(found["x_mm"] - x, found["y_mm"] - y)
    return away


if __name__ == "__main__":
    found, true = roll()
    away = error_mm(found, true)
    print(f"{len(found)} contacts, {np.sqrt(np.mean(away**2)):.2f} mm RMSE from MuJoCo's, at most {away.max():.2f} mm")
