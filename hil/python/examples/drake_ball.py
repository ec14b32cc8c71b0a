"""A ball that Drake presses into a soft pad and moves over it: its pressure field, felt on the emulated thimble.

    pip install palpate drake
    python drake_ball.py

Drake's hydroelastic contact has a pressure at every place of the surface between two bodies. Each face of that surface
presses with what its pressure comes to.
"""

from __future__ import annotations

import numpy as np
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    GeometryId,
    ProximityProperties,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, ContactModel, CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import PrismaticJoint, SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

import palpate
from palpate.physics import Pad, drake_contacts

DIAMETER_MM = 19.45
RADIUS_M = DIAMETER_MM / 2000
BEGIN_US, STEP_US = 700_000, 10_000


def proximity(properties: ProximityProperties) -> ProximityProperties:
    """Without friction: the ball slides."""
    smooth = CoulombFriction(static_friction=0, dynamic_friction=0)
    AddContactMaterial(dissipation=1.0, friction=smooth, properties=properties)
    return properties


def build(plant: MultibodyPlant) -> tuple[GeometryId, PrismaticJoint, PrismaticJoint]:
    """A pad whose surface is the plane z = 0, and a ball that goes along y and down: the pad's geometry, both joints."""
    soft, hard = ProximityProperties(), ProximityProperties()
    AddCompliantHydroelasticProperties(resolution_hint=0.004, hydroelastic_modulus=2e5, properties=soft)
    AddRigidHydroelasticProperties(resolution_hint=0.0015, properties=hard)
    pad = plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform([0, 0, -0.005]), Box(0.024, 0.024, 0.01), "pad", proximity(soft)
    )
    round_ = UnitInertia.SolidSphere(RADIUS_M)
    model = plant.AddModelInstance("ball")
    slide = plant.AddRigidBody("slide", model, SpatialInertia(0.001, np.zeros(3), round_))
    ball = plant.AddRigidBody("ball", model, SpatialInertia(0.03, np.zeros(3), round_))
    plant.RegisterCollisionGeometry(ball, RigidTransform(), Sphere(RADIUS_M), "ball", proximity(hard))
    along = plant.AddJoint(PrismaticJoint("along", plant.world_frame(), slide.body_frame(), [0, 1, 0]))
    down = plant.AddJoint(PrismaticJoint("down", slide.body_frame(), ball.body_frame(), [0, 0, 1]))
    plant.AddJointActuator("along", along)
    plant.AddJointActuator("down", down)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    return pad, along, down


def slide(seconds: float = 2.0) -> tuple[palpate.Table, np.ndarray, int]:
    """What the loop finds; Drake's own centre of pressure (rows of time (us), x, y (mm), force (N)); the faces of the
    largest surface."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.002)
    plant.set_contact_model(ContactModel.kHydroelastic)
    skin, along, down = build(plant)
    plant.Finalize()
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    down.set_translation(context, RADIUS_M)
    forces = plant.get_actuation_input_port(plant.GetModelInstanceByName("ball"))
    pad = Pad(origin_m=(0, 0, 0))
    loop = palpate.Loop("uskin-4x4", skin="emulated")
    loop.advance(BEGIN_US)
    found, true, faces = [], [], 0
    for step in range(int(seconds * 1e6) // STEP_US):
        phase = 2 * np.pi * step * STEP_US * 1e-6 / seconds
        to_m = 0.005 * np.sin(phase) - along.get_translation(context)
        push_n = 100 * to_m - 4 * along.get_translation_rate(context)
        forces.FixValue(context, [push_n, -(0.4 + 0.3 * (1 - np.cos(phase)))])
        simulator.AdvanceTo((step + 1) * STEP_US * 1e-6)
        places, normal = pad.presses(*drake_contacts(plant, context, skin))
        # A face is flat and small: how wide the ball is says the field itself.
        loop.touch(places, normal, diameter_mm=0.5)
        now_us = BEGIN_US + (step + 1) * STEP_US
        found.append(loop.advance(now_us).contacts)
        faces = max(faces, len(places))
        if len(places) > 0:
            true.append((now_us, *np.average(places, axis=0, weights=normal), normal.sum()))
    return np.concatenate(found).view(palpate.Table), np.array(true), faces


def error_mm(found: palpate.Table, true: np.ndarray) -> np.ndarray:
    """How far each contact that was found is from Drake's centre of pressure at its time, mm."""
    at = found["time_us"]
    x, y = (np.interp(at, true[:, 0], true[:, axis]) for axis in (1, 2))
    away: np.ndarray = np.hypot(found["x_mm"] - x, found["y_mm"] - y)
    return away


if __name__ == "__main__":
    found, true, faces = slide()
    away = error_mm(found, true)
    print(
        f"{len(found)} contacts of up to {faces} faces, {np.sqrt(np.mean(away**2)):.2f} mm RMSE from Drake's centre of "
        f"pressure, at most {away.max():.2f} mm"
    )
