"""Four fingertips of MuJoCo that close around a box and turn it, each felt on a thimble of its own.

    pip install palpate mujoco
    python mujoco_hand.py

The fingertips are round, so what they touch wanders over their skins while the box turns between them.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import mujoco
import numpy as np

import palpate
from palpate.physics import Pad, mujoco_contacts

TIP_M = 0.012
FINGERS = {"index": 0.022, "middle": 0.0, "ring": -0.022, "thumb": 0.0}
BEGIN_US, STEP_US = 700_000, 2_000


def finger(name: str, y_m: float) -> str:
    """A finger that bends about its base, which goes up and down: its skin looks at the box along x."""
    side = -1 if name == "thumb" else 1
    return f"""
    <body name="{name}" pos="{side * 0.046} {y_m} -0.06">
      <joint name="{name}-lift" type="slide" axis="0 0 1" damping="5"/>
      <joint name="{name}-bend" type="hinge" axis="0 {-side} 0" damping="0.003"/>
      <geom type="capsule" size="0.006" fromto="0 0 0 0 0 0.045" contype="0" conaffinity="0" mass="0.02"/>
      <body name="{name}-tip" pos="0 0 0.06" xyaxes="0 {-side} 0 0 0 1">
        <geom name="{name}-skin" type="sphere" size="{TIP_M}" mass="0.02"/>
      </body>
    </body>"""


def world() -> str:
    """The hand around a box that floats until it is gripped."""
    fingers = "".join(finger(name, y) for name, y in FINGERS.items())
    lifts = "".join(
        f'<position name="{name}-lift" joint="{name}-lift" kp="400" kv="10"/>' for name in FINGERS
    )
    bends = "".join(f'<motor name="{name}-bend" joint="{name}-bend"/>' for name in FINGERS)
    return f"""
<mujoco>
  <option timestep="0.0005" gravity="0 0 0"/>
  <default><geom friction="1 0.005 0.0001" condim="4"/></default>
  <worldbody>
    <body name="box">
      <freejoint/>
      <geom name="box" type="box" size="0.03 0.04 0.05" mass="0.1"/>
    </body>
    {fingers}
  </worldbody>
  <actuator>{lifts}{bends}</actuator>
</mujoco>"""


@dataclass
class Tip:
    """A fingertip: its skin, its thimble, and what came of them."""

    name: str
    geom: int
    body: int
    loop: palpate.Loop = field(default_factory=lambda: palpate.Loop("uskin-4x4", skin="emulated"))
    found: list[palpate.Table] = field(default_factory=list)
    felt: list[palpate.Table] = field(default_factory=list)
    true: list[tuple[float, ...]] = field(default_factory=list)

    def pad(self, data: mujoco.MjData) -> Pad:
        """Its skin in the world now: the plane that touches the tip where it faces the box."""
        axes = data.xmat[self.body].reshape(3, 3)
        return Pad(data.xpos[self.body] + TIP_M * axes[:, 2], axes)

    def step(self, model: mujoco.MjModel, data: mujoco.MjData, now_us: int) -> None:
        """Hands the simulator's contacts to the skin, and lets time go on."""
        places, forces = self.pad(data).presses(*mujoco_contacts(model, data, self.geom))
        self.loop.touch(places, forces, diameter_mm=2000 * TIP_M)
        step = self.loop.advance(now_us)
        self.found.append(step.contacts)
        self.felt.append(step.felt)
        if len(places) == 1:
            self.true.append((now_us, *places[0], forces[0]))


def grasp(seconds: float = 5.0) -> dict[str, Tip]:
    """Closes the hand, and turns the box one way and then the other."""
    model = mujoco.MjModel.from_xml_string(world())
    data = mujoco.MjData(model)
    tips = [Tip(n, model.geom(f"{n}-skin").id, model.body(f"{n}-tip").id) for n in FINGERS]
    for tip in tips:
        tip.loop.advance(BEGIN_US)
    for step in range(int(seconds * 1e6) // STEP_US):
        t = step * STEP_US * 1e-6
        turn_m = 0.008 * np.sin(2 * np.pi * np.clip((t - 0.5) / (seconds - 0.5), 0, 1))
        for name in FINGERS:
            # The thumb holds against three.
            force_n = (1.2 if name == "thumb" else 0.4) * (1 + 0.2 * np.sin(2 * np.pi * t))
            data.actuator(f"{name}-bend").ctrl = force_n * 0.06
            data.actuator(f"{name}-lift").ctrl = turn_m if name == "thumb" else -turn_m
        for _ in range(4):
            mujoco.mj_step(model, data)
        for tip in tips:
            tip.step(model, data, BEGIN_US + (step + 1) * STEP_US)
    return {tip.name: tip for tip in tips}


def error_mm(tip: Tip) -> np.ndarray:
    """How far each contact that was found is from MuJoCo's at its time, mm."""
    found = np.concatenate(tip.found)
    true = np.array(tip.true)
    found = found[found["time_us"] <= true[-1, 0]]
    x, y = (np.interp(found["time_us"], true[:, 0], true[:, axis]) for axis in (1, 2))
    away: np.ndarray = np.hypot(found["x_mm"] - x, found["y_mm"] - y)
    return away


if __name__ == "__main__":
    for name, tip in grasp().items():
        away = error_mm(tip)
        felt = np.concatenate(tip.felt)
        print(
            f"{name}: {len(away)} contacts, {np.sqrt(np.mean(away**2)):.2f} mm RMSE from MuJoCo's, at most "
            f"{away.max():.2f} mm; {felt['felt'].sum()} of {len(felt)} onsets felt"
        )
