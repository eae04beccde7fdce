"""Checks whether lanes support a model, and names what they do not support."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from estexp_jax.lanes.collision_pairs import contacts_on, touching_pairs
from estexp_jax.lanes.contact_candidates import SHAPES
from estexp_jax.lanes.rays import TOUCH_SHAPES
from estexp_jax.lanes.sensor_frames import FRAMES, on_fixed_body
from estexp_jax.lanes.sensors import RESTING, SENSORS

_GEOM, _JOINT, _ON = mujoco.mjtGeom, mujoco.mjtJoint, mujoco.mjtEnableBit
_COUNTED = {
    "ntendon": "tendons",
    "nflex": "flexible bodies",
    "nmocap": "mocap bodies",
    "npair": "explicit contact pairs",
    "nplugin": "plugins",
    "na": "actuators with a state of their own",
    "nhistory": "delayed actuators or sensors",
    "nplastic": "plastic joints",
}
_PLAIN = {
    "actuator_armature": "actuator armature",
    "actuator_damping": "actuator damping",
    "jnt_actgravcomp": "gravity compensation by actuators",
    "body_gravcomp": "gravity compensation",
    "geom_adhesion": "adhesion",
    "geom_surfacevel": "moving surfaces",
}
"""Fields that are zero in a model that does not use them."""


def refusal(model: mujoco.MjModel) -> str | None:
    """Why lanes cannot simulate a model, in words, naming the element; None where they can."""
    return next(_reasons(model), None)


def _name(model: mujoco.MjModel, kind: mujoco.mjtObj, index: int) -> str:
    word = kind.name.removeprefix("mjOBJ_").lower()
    return mujoco.mj_id2name(model, kind, index) or f"{word}_{index}"


def _reasons(model: mujoco.MjModel) -> Iterator[str]:
    yield from _elements(model)
    yield from _options(model)
    yield from _joints(model)
    yield from _actuators(model)
    yield from _sensors(model)
    yield from _contacts(model)


def _elements(model: mujoco.MjModel) -> Iterator[str]:
    for i in range(model.neq):
        if model.eq_active0[i]:
            yield f"equality constraint '{_name(model, mujoco.mjtObj.mjOBJ_EQUALITY, i)}' is not supported"
    for field, what in _COUNTED.items():
        if getattr(model, field, 0):
            yield f"{what} are not supported"
    for field, what in _PLAIN.items():
        values = getattr(model, field, None)
        if values is not None and np.any(values):
            yield f"{what} is not supported" if not what.endswith("s") else f"{what} are not supported"
    if not model.njnt:
        yield "a model without joints is not supported"


def _options(model: mujoco.MjModel) -> Iterator[str]:
    option, kinds = model.opt, mujoco.mjtIntegrator
    allowed = (kinds.mjINT_EULER, kinds.mjINT_RK4, kinds.mjINT_IMPLICITFAST)
    if option.integrator not in allowed:
        yield f"integrator {kinds(option.integrator).name.removeprefix('mjINT_').lower()} is not supported"
    if option.density or option.viscosity or np.any(option.wind):
        yield "a surrounding fluid is not supported"
    condims = [int(max(model.geom_condim[a], model.geom_condim[b])) for a, b in _pairs(model)]
    if option.cone == mujoco.mjtCone.mjCONE_ELLIPTIC and any(c > 1 for c in condims):
        yield "elliptic friction cones are not supported"
    if option.noslip_iterations:
        yield "the noslip solver is not supported"
    if option.disableactuator:
        yield "disabled groups of actuators are not supported"
    if option.enableflags & (_ON.mjENBL_OVERRIDE | _ON.mjENBL_INVDISCRETE | _ON.mjENBL_DIAGEXACT | _ON.mjENBL_SLEEP):
        yield "an option under <flag> that is off by default is not supported"


def _joints(model: mujoco.MjModel) -> Iterator[str]:
    fast = model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    for j in range(model.njnt):
        name, dof = _name(model, mujoco.mjtObj.mjOBJ_JOINT, j), int(model.jnt_dofadr[j])
        if int(model.jnt_type[j]) == _JOINT.mjJNT_BALL:
            yield f"ball joint '{name}' is not supported"
        if int(model.jnt_type[j]) == _JOINT.mjJNT_FREE:
            if model.jnt_stiffness[j] or np.any(model.jnt_stiffnesspoly[j]):
                yield f"stiffness of free joint '{name}' is not supported"
            if np.any(model.dof_dampingpoly[dof : dof + 6]):
                yield f"a damping polynomial of free joint '{name}' is not supported"
            if np.any(model.dof_frictionloss[dof : dof + 6]):
                yield f"friction loss of free joint '{name}' is not supported"
            if fast and model.tree_dofnum[model.dof_treeid[dof]] == 6:  # MuJoCo takes its gyroscopic forces implicitly
                yield f"integrator implicitfast for the lone free joint '{name}' is not supported"
    for body in range(1, model.nbody):
        if model.body_weldid[body] != 0 and model.body_jntnum[body] > 1:
            first = int(model.body_jntadr[body])
            if int(model.jnt_type[first]) == _JOINT.mjJNT_FREE:
                name = _name(model, mujoco.mjtObj.mjOBJ_BODY, body)
                yield f"a free joint beside others on body '{name}' is not supported"
    springy = getattr(model, "jnt_springyield", np.zeros(0))
    if np.any(np.isfinite(springy) & (springy > 0)):
        yield "yielding springs are not supported"


def _actuators(model: mujoco.MjModel) -> Iterator[str]:
    gains, biases = mujoco.mjtGain, mujoco.mjtBias
    for a in range(model.nactuator):
        name = _name(model, mujoco.mjtObj.mjOBJ_ACTUATOR, a)
        if int(model.actuator_ctrlnum[a]) != 1 or int(model.actuator_outnum[a]) != 1:
            yield f"actuator '{name}' with several inputs or none is not supported"
        if int(model.actuator_trntype[a]) != mujoco.mjtTrn.mjTRN_JOINT:
            yield f"the transmission of actuator '{name}' is not supported"
        elif int(model.jnt_type[model.actuator_trnid[a, 0]]) not in (_JOINT.mjJNT_HINGE, _JOINT.mjJNT_SLIDE):
            yield f"actuator '{name}' on a free joint is not supported"
        if int(model.actuator_gaintype[a]) not in (gains.mjGAIN_FIXED, gains.mjGAIN_AFFINE):
            yield f"the gain type of actuator '{name}' is not supported"
        if int(model.actuator_biastype[a]) not in (biases.mjBIAS_NONE, biases.mjBIAS_AFFINE):
            yield f"the bias type of actuator '{name}' is not supported"


def _sensors(model: mujoco.MjModel) -> Iterator[str]:
    for s in range(model.nsensor):
        name = _name(model, mujoco.mjtObj.mjOBJ_SENSOR, s)
        kind = mujoco.mjtSensor(int(model.sensor_type[s]))
        if kind not in SENSORS:
            word = kind.name.removeprefix("mjSENS_").lower()
            yield f"sensor '{name}' of type {word} is not supported"
        elif int(model.sensor_reftype[s]) != mujoco.mjtObj.mjOBJ_UNKNOWN:
            yield f"the reference frame of sensor '{name}' is not supported"
        elif kind == mujoco.mjtSensor.mjSENS_TOUCH and int(model.site_type[model.sensor_objid[s]]) not in TOUCH_SHAPES:
            yield f"the shape of the site of touch sensor '{name}' is not supported"
        elif kind not in RESTING and on_fixed_body(model, s):
            yield f"sensor '{name}' on a body that cannot move is not supported"
        elif kind in RESTING and mujoco.mjtObj(int(model.sensor_objtype[s])) not in FRAMES:
            yield f"sensor '{name}' on a camera is not supported"


def _pairs(model: mujoco.MjModel) -> list[tuple[int, int]]:
    return touching_pairs(model) if contacts_on(model) else []


def _contacts(model: mujoco.MjModel) -> Iterator[str]:
    for plane, geom in _pairs(model):
        one, two = (_name(model, mujoco.mjtObj.mjOBJ_GEOM, g) for g in (plane, geom))
        if int(model.geom_type[plane]) != _GEOM.mjGEOM_PLANE or int(model.geom_type[geom]) == _GEOM.mjGEOM_PLANE:
            yield f"contact between geoms '{one}' and '{two}' is not supported"
        elif model.body_weldid[model.geom_bodyid[plane]] != 0:
            yield f"plane '{one}' on a moving body is not supported"
        elif int(model.geom_type[geom]) not in SHAPES:
            yield f"contact of the shape of geom '{two}' is not supported"
        elif max(int(model.geom_condim[g]) for g in (plane, geom)) not in (1, 3):
            yield f"contact of geom '{two}' with torsional or rolling friction is not supported"
