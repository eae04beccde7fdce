"""Elements that MJX lacks and that hardly affect a robot's motion: left out and reported, not refused.

Solver and integrator make no other robot, only other steps. A contact that MJX has no function for is left out between
two parts of a robot, and between a robot that is bolted down and what stands around it; what a robot may stand on is
not. So are contacts of meshes that overlap at home: they push all the time, and hold what a real robot can move.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from estexp_jax.errors import InputError, listing
from estexp_jax.lanes.collision_pairs import contacts_on, touching_pairs
from estexp_jax.physics.model.actuators import unusual_actuator
from estexp_jax.physics.model.collision_pairs import overlapping_bodies
from estexp_jax.physics.model.robot import Robot

_GEOM, _JOINT = mujoco.mjtGeom, mujoco.mjtJoint
_INTEGRATOR, _ENABLE = mujoco.mjtIntegrator, mujoco.mjtEnableBit
APART = frozenset(
    {
        (_GEOM.mjGEOM_HFIELD, _GEOM.mjGEOM_ELLIPSOID),
        (_GEOM.mjGEOM_HFIELD, _GEOM.mjGEOM_CYLINDER),
        (_GEOM.mjGEOM_ELLIPSOID, _GEOM.mjGEOM_BOX),
        (_GEOM.mjGEOM_ELLIPSOID, _GEOM.mjGEOM_MESH),
        (_GEOM.mjGEOM_CYLINDER, _GEOM.mjGEOM_BOX),
        (_GEOM.mjGEOM_CYLINDER, _GEOM.mjGEOM_MESH),
    }
)
"""Shapes that MJX cannot let touch."""
_WORDS = {
    _GEOM.mjGEOM_HFIELD: "a height field",
    _GEOM.mjGEOM_ELLIPSOID: "an ellipsoid",
    _GEOM.mjGEOM_CYLINDER: "a cylinder",
    _GEOM.mjGEOM_BOX: "a box",
    _GEOM.mjGEOM_MESH: "a mesh",
}
_ROUGH = (_GEOM.mjGEOM_MESH, _GEOM.mjGEOM_HFIELD)
"""Shapes whose contacts begin at touch in MJX."""
_IDLE = int(_ENABLE.mjENBL_ENERGY) | int(_ENABLE.mjENBL_FWDINV)
"""Flags that change no motion, and that MJX does not know."""
_UNKNOWN = {
    "actuator_damping": "damping of actuators other than at hinges and slides",
    "actuator_dampingpoly": "damping polynomials of actuators other than at hinges and slides",
    "actuator_armature": "armature of actuators other than at hinges and slides",
    "actuator_delay": "delays of actuators",
    "sensor_delay": "delays of sensors",
    "tendon_dampingpoly": "damping polynomials of tendons",
    "tendon_stiffnesspoly": "stiffness polynomials of tendons",
    "geom_adhesion": "adhesion",
    "geom_surfacevel": "moving surfaces",
}
"""Fields that MJX 3.17 passes over in silence; they are zero in a model that does not use them."""


class ReducedRobot(NamedTuple):
    """A model within what MJX can simulate.

    Attributes:
        model: compiled, a copy.
        left_out: what the robot's own has and it has not; each follows "simulated without".
    """

    model: mujoco.MjModel
    left_out: tuple[str, ...]


def reduced_to_mjx(robot: Robot) -> ReducedRobot:
    """A robot's model without what MJX lacks and its motion hardly needs.

    Raises:
        InputError: two shapes that MJX cannot let touch may carry the robot, or an actuator has several inputs or none.
    """
    if (odd := unusual_actuator(robot.model)) is not None:
        name, right = robot.names("actuator")[odd[0]], "use --engine c; or actuators with one input each"
        raise InputError(f"MJX has no actuator with {odd[1]}: '{name}'", where=robot.source, right=right)
    left_out = _left_out(robot)
    fused = [bodies for bodies in overlapping_bodies(robot) if bodies not in left_out]
    model = copy.deepcopy(robot.without_contacts([*left_out, *fused]).model)
    _to_joints(model)
    without = *_contacts(robot, left_out), *_overlaps(robot, fused)
    left_out = (*without, *_without_margins(model), *_options(model.opt), *_passed_over(model))
    return ReducedRobot(model, left_out)


def _to_joints(model: mujoco.MjModel) -> None:
    """Give joints the damping and armature of the actuators that turn them."""
    scalar = (int(_JOINT.mjJNT_HINGE), int(_JOINT.mjJNT_SLIDE))
    for a in range(model.nactuator):
        joint, gear = int(model.actuator_trnid[a, 0]), float(model.actuator_gear[a, 0])
        if int(model.actuator_trntype[a]) != mujoco.mjtTrn.mjTRN_JOINT or int(model.jnt_type[joint]) not in scalar:
            continue
        dof = int(model.jnt_dofadr[joint])
        model.dof_armature[dof] += gear**2 * model.actuator_armature[a]
        model.dof_damping[dof] += gear**2 * model.actuator_damping[a]
        model.dof_dampingpoly[dof] += gear**2 * model.actuator_dampingpoly[a]
        model.actuator_armature[a] = model.actuator_damping[a] = 0.0
        model.actuator_dampingpoly[a] = 0.0


def _passed_over(model: mujoco.MjModel) -> Iterator[str]:
    """Sentences on what MJX would ignore silently."""
    for field, what in _UNKNOWN.items():
        if np.any(getattr(model, field)):
            yield what
    round_joints = ~np.isin(model.jnt_type, (int(_JOINT.mjJNT_HINGE), int(_JOINT.mjJNT_SLIDE)))
    if np.any(model.jnt_stiffnesspoly[round_joints]):
        yield "stiffness polynomials of ball and free joints"
    springy = getattr(model, "jnt_springyield", np.zeros(0))  # since MuJoCo 4
    if np.any(np.isfinite(springy) & (springy > 0)):
        yield "springs that yield"


def _options(option: mujoco.MjOption) -> Iterator[str]:
    """Solver and integrator that MJX has in place of those it has not; sentences."""
    option.enableflags &= ~_IDLE
    if option.solver == mujoco.mjtSolver.mjSOL_PGS:
        option.solver = mujoco.mjtSolver.mjSOL_NEWTON
        yield "the solver PGS: Newton's, which solves the same, takes its place"
    fluid = option.density > 0 or option.viscosity > 0 or np.any(option.wind)
    if option.integrator == _INTEGRATOR.mjINT_IMPLICITFAST and fluid:
        option.integrator = _INTEGRATOR.mjINT_EULER
        yield "the integrator implicitfast in a fluid: Euler's takes its place"
    elif option.integrator == _INTEGRATOR.mjINT_IMPLICIT:
        option.integrator = _INTEGRATOR.mjINT_EULER if fluid else _INTEGRATOR.mjINT_IMPLICITFAST
        yield f"the integrator implicit: {'Euler' if fluid else 'implicitfast'} takes its place"


def _without_margins(model: mujoco.MjModel) -> Iterator[str]:
    """Contacts that begin at touch wherever a mesh or a height field may touch; a sentence."""
    collides = (model.geom_contype | model.geom_conaffinity) > 0
    rough = collides & np.isin(model.geom_type, [int(shape) for shape in _ROUGH])
    if rough.any() and np.any(model.geom_margin[collides]):
        model.geom_margin[:] = 0.0
        model.geom_gap[:] = 0.0
        yield "margins of contacts: meshes and height fields have none"


def _left_out(robot: Robot) -> dict[tuple[int, int], tuple[str, str]]:
    """Pairs of bodies that cannot be let touch, and the shapes of two of their geoms that cannot."""
    model, geoms, found = robot.model, robot.names("geom"), dict[tuple[int, int], tuple[str, str]]()
    for a, b in _pairs(model):
        one, other = int(model.geom_bodyid[a]), int(model.geom_bodyid[b])
        shape, second = (_WORDS[_GEOM(int(model.geom_type[g]))] for g in (a, b))
        still = [int(model.body_weldid[body]) == 0 for body in (one, other)]
        if contacts_on(model) and any(still) and (robot.floats(one) or robot.floats(other)):
            raise InputError(
                f"MJX has no contact of {shape} with {second}: '{geoms[a]}' and '{geoms[b]}'",
                where=robot.source,
                right="make one a capsule or a sphere, or keep them from touching (contype, conaffinity, exclude)",
            )
        found.setdefault((min(one, other), max(one, other)), (shape, second))
    return found


def _contacts(robot: Robot, left_out: Mapping[tuple[int, int], tuple[str, str]]) -> Iterator[str]:
    """Contacts that are left out, a sentence."""
    if left_out and contacts_on(robot.model):
        bodies = robot.names("body")
        shapes = sorted({f"{one} with {other}" for one, other in left_out.values()})
        pairs = listing(f"{bodies[a]} and {bodies[b]}" for a, b in left_out)
        yield f"contacts between {pairs}: MJX has none of {' or of '.join(shapes)}"


def _overlaps(robot: Robot, fused: Sequence[tuple[int, int]]) -> Iterator[str]:
    """Contacts of meshes that overlap, a sentence."""
    if fused and contacts_on(robot.model):
        bodies = robot.names("body")
        pairs = listing(f"{bodies[a]} and {bodies[b]}" for a, b in fused)
        yield f"contacts between {pairs}: their meshes, with hollows filled, overlap at home"


def _pairs(model: mujoco.MjModel) -> Iterator[tuple[int, int]]:
    """Geoms that touch in the C engine and have no function in MJX, the lower type first.

    MJX refuses them also where contacts are switched off.
    """
    for pair in touching_pairs(model):
        a, b = sorted(pair, key=lambda g: int(model.geom_type[g]))
        if (_GEOM(int(model.geom_type[a])), _GEOM(int(model.geom_type[b]))) in APART:
            yield a, b
