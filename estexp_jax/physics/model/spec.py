"""Descriptions that can be changed element by element: each has a name, and nothing is worked out anew from the whole.

MuJoCo's compiler derives servo damping (`dampratio`), joint springs (`springdamper`) and masses (`settotalmass`,
`inertiafromgeom`) from the robot's inertia. A heavier leg does not change the motors, so what was derived once stays.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import mujoco
import numpy as np

_ROUNDING = 1e-6
"""Part of a step by which a buffer may be too short."""
Index = Callable[[str, str], int]
"""MuJoCo's index in the nominal model of an element of a kind by its name."""


def spec_elements(spec: mujoco.MjSpec) -> dict[str, Sequence[Any]]:
    """The elements of a description that effects change, by kind."""
    return {"body": spec.bodies, "joint": spec.joints, "actuator": spec.actuators, "sensor": spec.sensors}


def with_names(spec: mujoco.MjSpec) -> mujoco.MjSpec:
    """A copy of a compiled description in which the unnamed are called `<kind>_<index>`.

    Indices shift when a part is deleted from a description; names stay.
    """
    spec = spec.copy()
    for kind, some in spec_elements(spec).items():
        taken = {element.name for element in some}
        for element in some:
            if not element.name and f"{kind}_{element.id}" not in taken:
                element.name = f"{kind}_{element.id}"
    return spec


def freeze(spec: mujoco.MjSpec, nominal: mujoco.MjModel, index: Index) -> None:
    """Write down, in place, what the compiler derived from the nominal robot as a whole; twice changes nothing more."""
    for joint in spec.joints:
        if np.any(joint.springdamper):
            j = index("joint", joint.name)
            joint.stiffness = [nominal.jnt_stiffness[j], *joint.stiffness[1:]]
            joint.damping = [nominal.dof_damping[nominal.jnt_dofadr[j]], *joint.damping[1:]]
            joint.springdamper = [0.0, 0.0]
    servos = (a for a in spec.actuators if a.biastype == mujoco.mjtBias.mjBIAS_AFFINE)
    for actuator in servos:
        derived = nominal.actuator_biasprm[index("actuator", actuator.name)]
        if actuator.biasprm[2] > 0.0 > derived[2]:  # so MjSpec holds dampratio, to be replaced by -kv
            actuator.biasprm = derived
    if spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE:
        _write_masses(spec, nominal, lambda body: index("body", body.name))


def with_masses(spec: mujoco.MjSpec, nominal: mujoco.MjModel) -> mujoco.MjSpec:
    """A compiled description with its masses in it, not their sum: of `settotalmass` MuJoCo warns each time.

    The centre of a mass that was given in Python without one is the body's origin: MuJoCo 4.0.0 compiles it so, and
    leaves the mass out of what it writes.
    """
    for body in spec.bodies[1:]:
        if body.explicitinertial and np.isnan(body.ipos).any():
            body.ipos = nominal.body_ipos[body.id]
    if spec.compiler.settotalmass > 0.0:
        _write_masses(spec, nominal, lambda body: body.id)
    return spec


def _write_masses(spec: mujoco.MjSpec, nominal: mujoco.MjModel, index: Callable[[Any], int]) -> None:
    spec.compiler.settotalmass = -1.0
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO
    for body in spec.bodies[1:]:
        b = index(body)
        if nominal.body_mass[b] > 0.0:
            body.explicitinertial = False  # what it says was not used
            set_masses(body, nominal, b, float(nominal.body_mass[b]))


def set_timestep(spec: mujoco.MjSpec, step: float) -> None:
    """Give a description another step, s; delays stay as long as they are, and the buffers that hold them."""
    shorter = spec.option.timestep / step
    for element in (*spec.actuators, *spec.sensors):
        if element.nsample > 0 and shorter > 1.0:
            element.nsample = int(np.ceil(element.nsample * shorter - _ROUNDING))
    spec.option.timestep = step


def set_masses(body: Any, nominal: mujoco.MjModel, index: int, mass: float) -> None:
    """Give a body of a description this mass, its nominal inertia scaled with it, about the centre it has."""
    centre = body.ipos if body.explicitinertial else nominal.body_ipos[index]
    body.explicitinertial, body.fullinertia = True, np.full(6, np.nan)
    body.mass, body.inertia = mass, nominal.body_inertia[index] * (mass / nominal.body_mass[index])
    body.ipos, body.iquat = centre, nominal.body_iquat[index]
