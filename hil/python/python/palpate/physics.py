"""Contacts of any simulator as presses on the emulated skin."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import InputError

__all__ = ["Pad", "drake_contacts", "mujoco_contacts"]


@dataclass(frozen=True)
class Pad:
    """Where a module's skin lies in a simulator's world.

    Attributes:
        origin_m: The module's centre on the skin, m, shape (3,).
        rotation: Its axes as columns, shape (3, 3): x to the right, y up, z out of the skin. Default: the world's.
    """

    origin_m: npt.ArrayLike
    rotation: npt.ArrayLike = field(default_factory=lambda: np.eye(3))

    def presses(
        self, points_m: npt.ArrayLike, forces_n: npt.ArrayLike
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Places (mm, shape (n, 2)) and normal forces (N, shape (n,)) for ``Loop.touch``.

        Contacts that do not press are left out, and friction is: the emulated skin takes normal forces.

        Args:
            points_m: Contact points in the world, m, shape (contacts, 3).
            forces_n: Forces on the skin in the world, N, shape (contacts, 3).
        """
        points, forces = _vectors(points_m, "points_m"), _vectors(forces_n, "forces_n")
        if len(points) != len(forces):
            raise InputError.of("forces_n", f"{len(points)} forces, one per point", f"{len(forces)}")
        axes = np.asarray(self.rotation, dtype=np.float64)
        if axes.shape != (3, 3) or not np.allclose(axes.T @ axes, np.eye(3), atol=1e-6):
            raise InputError.of("rotation", "a rotation of shape (3, 3)", repr(self.rotation))
        local = (points - np.asarray(self.origin_m, dtype=np.float64)) @ axes
        normal = -(forces @ axes[:, 2])
        pressing = normal > 0
        return local[pressing, :2] * 1e3, normal[pressing]


def mujoco_contacts(
    model: Any, data: Any, geom: int
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Contact points of a geom of MuJoCo's in the world, m, and the forces on it there, N, both of shape (contacts, 3).

    MuJoCo's tactile sensors are no taxels: the depth that they report depends on the mass of what touches.

    Args:
        model: ``mujoco.MjModel``.
        data: ``mujoco.MjData`` after a step.
        geom: The geom's number, ``model.geom("pad").id``.
    """
    import mujoco

    points, forces = [], []
    wrench = np.zeros(6)
    for number, contact in enumerate(data.contact):
        if geom not in contact.geom:
            continue
        mujoco.mj_contactForce(model, data, number, wrench)
        # In the contact's frame, on the second geom; the rows of `frame` are its axes.
        on_second = contact.frame.reshape(3, 3).T @ wrench[:3]
        points.append(contact.pos.copy())
        forces.append(on_second if contact.geom[1] == geom else -on_second)
    return np.array(points).reshape(-1, 3), np.array(forces).reshape(-1, 3)


def drake_contacts(
    plant: Any, context: Any, geometry: Any
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """The pressure field on a geometry of Drake's: the centre of every face of the contact surfaces in the world, m, and
    the force on the geometry there, N, both of shape (faces, 3).

    Contacts at points, which Drake falls back to for bodies without a pressure field, are left out.

    Args:
        plant: ``pydrake.multibody.plant.MultibodyPlant`` with hydroelastic contact.
        context: The plant's own context after a step.
        geometry: The ``GeometryId`` of the skin.
    """
    results = plant.get_contact_results_output_port().Eval(context)
    points, forces = [], []
    for number in range(results.num_hydroelastic_contacts()):
        surface = results.hydroelastic_contact_info(number).contact_surface()
        if geometry not in (surface.id_M(), surface.id_N()):
            continue
        # Normals point out of N into M: pressure pushes M along them.
        side = 1.0 if geometry == surface.id_M() else -1.0
        triangles = surface.is_triangle()
        field = surface.tri_e_MN() if triangles else surface.poly_e_MN()
        for face in range(surface.num_faces()):
            at = surface.centroid(face)
            points.append(at)
            forces.append(side * field.EvaluateCartesian(face, at) * surface.area(face) * surface.face_normal(face))
    return np.array(points).reshape(-1, 3), np.array(forces).reshape(-1, 3)


def _vectors(values: npt.ArrayLike, what: str) -> npt.NDArray[np.float64]:
    found: npt.NDArray[Any] = np.asarray(values, dtype=np.float64)
    if found.size == 0:
        return found.reshape(0, 3)
    if found.ndim != 2 or found.shape[1] != 3 or not np.isfinite(found).all():
        raise InputError.of(what, "finite numbers of shape (contacts, 3)", f"shape {found.shape}")
    return found
