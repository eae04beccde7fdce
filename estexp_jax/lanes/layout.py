"""The structure of a robot as lanes step it: alike limbs side by side, degrees of freedom in the order of the tree.

Sibling bodies with alike subtrees (same joints, motors and contacts; other numbers) form one group of k members, and
each of their scalars is one array (k, N). Degrees of freedom are counted per group, parents before children.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import mujoco
import numpy as np

from estexp_jax.lanes.contact_candidates import Candidate, candidates

_JOINT = mujoco.mjtJoint


@final
@dataclass(frozen=True)
class Motor:
    """Alike actuators, one of each member of a joint.

    Attributes:
        ids: (k,) MuJoCo's indices.
    """

    ids: tuple[int, ...]


@final
@dataclass(frozen=True)
class Joint:
    """Alike joints, one of each member of a group.

    Attributes:
        kind: MuJoCo's type: free, hinge or slide.
        ids: (k,) MuJoCo's indices.
        qpos, dof: (k,) first addresses in qpos and qvel.
        dofs: its degrees of freedom in our count.
        limited: whether it has stops.
        motors: what drives it.
    """

    kind: mujoco.mjtJoint
    ids: tuple[int, ...]
    qpos: tuple[int, ...]
    dof: tuple[int, ...]
    dofs: tuple[int, ...]
    limited: bool
    motors: tuple[Motor, ...]

    @property
    def free(self) -> bool:
        """Whether it is a free joint."""
        return self.kind == _JOINT.mjJNT_FREE

    @property
    def hinge(self) -> bool:
        """Whether it is a hinge."""
        return self.kind == _JOINT.mjJNT_HINGE


@final
@dataclass(frozen=True)
class Group:
    """Alike bodies.

    Attributes:
        index: in `Layout.groups`.
        bodies: (k,) MuJoCo's indices, children of one parent side by side.
        parent: index of the parents' group, None on the world.
        joints: in MuJoCo's order.
        chain: our degrees of freedom that move it, its own last.
        touches: points that may touch a plane.
    """

    index: int
    bodies: tuple[int, ...]
    parent: int | None
    joints: tuple[Joint, ...]
    chain: tuple[int, ...]
    touches: tuple[Candidate, ...]

    @property
    def k(self) -> int:
        """Number of members."""
        return len(self.bodies)


@final
@dataclass(frozen=True)
class Dof:
    """Alike degrees of freedom.

    Attributes:
        index: in `Layout.dofs`.
        addresses: (k,) in qvel.
        above: our indices of those it hangs from, topmost first.
        has_friction_loss: whether there is friction loss.
    """

    index: int
    addresses: tuple[int, ...]
    above: tuple[int, ...]
    has_friction_loss: bool

    @property
    def k(self) -> int:
        """Number of members."""
        return len(self.addresses)


@final
@dataclass(frozen=True, eq=False)
class Layout:
    """A robot's structure."""

    model: mujoco.MjModel
    groups: tuple[Group, ...]
    dofs: tuple[Dof, ...]

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """All joints, in the order of the groups."""
        return tuple(joint for group in self.groups for joint in group.joints)

    @cached_property
    def children(self) -> tuple[tuple[Group, ...], ...]:
        """The groups that hang from each group."""
        return tuple(tuple(g for g in self.groups if g.parent == i) for i in range(len(self.groups)))

    @cached_property
    def place_of_body(self) -> dict[int, tuple[int, int]]:
        """Group and member of each moving body."""
        return {b: (g.index, i) for g in self.groups for i, b in enumerate(g.bodies)}


def layout_of(model: mujoco.MjModel) -> Layout:
    """The structure of a compiled model that `refusal` finds nothing against."""
    return _LayoutBuilder(model).build()


@final
class _LayoutBuilder:
    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = model
        self._groups: list[Group] = []
        self._dofs: list[Dof] = []
        self._touches = candidates(model)
        self._signatures: dict[int, Any] = {}

    def build(self) -> Layout:
        model = self._model
        for body in range(1, model.nbody):
            if model.body_weldid[body] != 0 and model.body_weldid[model.body_parentid[body]] == 0:
                self._add((body,), None)
        return Layout(model, tuple(self._groups), tuple(self._dofs))

    def _children(self, body: int) -> list[int]:
        return [c for c in range(body + 1, self._model.nbody) if self._model.body_parentid[c] == body]

    def _joints(self, body: int) -> list[int]:
        first = int(self._model.body_jntadr[body])
        return list(range(first, first + int(self._model.body_jntnum[body])))

    def _signature(self, body: int) -> Any:
        """Properties that alike subtrees share."""
        if body not in self._signatures:
            self._signatures[body] = (
                tuple(self._joint_signature(j) for j in self._joints(body)),
                tuple(t.signature for t in self._touches.get(body, ())),
                tuple(sorted(self._signature(c) for c in self._children(body))),
            )
        return self._signatures[body]

    def _joint_signature(self, joint: int) -> Any:
        model = self._model
        motors = tuple(
            (int(model.actuator_gaintype[a]), int(model.actuator_biastype[a]))
            + tuple(bool(x[a]) for x in (model.actuator_ctrllimited, model.actuator_forcelimited))
            for a in self._motors(joint)
        )
        return (
            int(model.jnt_type[joint]),
            bool(model.jnt_limited[joint]),
            bool(model.jnt_actfrclimited[joint]),
            bool(model.dof_frictionloss[model.jnt_dofadr[joint]] > 0.0),
            motors,
        )

    def _motors(self, joint: int) -> list[int]:
        return [a for a in range(self._model.nu) if int(self._model.actuator_trnid[a, 0]) == joint]

    def _add(self, bodies: tuple[int, ...], parent: Group | None) -> None:
        index, above = len(self._groups), parent.chain if parent else ()
        joints: list[Joint] = []
        for slot in zip(*(self._joints(b) for b in bodies), strict=True):
            joints.append(self._joint(slot, above))
            above = (*above, *joints[-1].dofs)
        touches = tuple(
            Candidate.joined(slot) for slot in zip(*(self._touches.get(b, ()) for b in bodies), strict=True)
        )
        if len(bodies) == 1:
            touches = _merged(touches)
        group = Group(index, bodies, parent.index if parent else None, tuple(joints), above, touches)
        self._groups.append(group)
        alike: dict[Any, list[int]] = {}
        for body in bodies:
            for child in sorted(self._children(body), key=lambda c: (self._signature(c), c)):
                alike.setdefault(self._signature(child), []).append(child)
        for members in alike.values():
            self._add(tuple(members), group)

    def _joint(self, ids: Sequence[int], above: tuple[int, ...]) -> Joint:
        model, first = self._model, ids[0]
        kind = _JOINT(int(model.jnt_type[first]))
        address = model.jnt_dofadr[list(ids)]
        dofs: list[int] = []
        for i in range(6 if kind == _JOINT.mjJNT_FREE else 1):
            has_friction_loss = bool(np.any(model.dof_frictionloss[address + i] > 0.0))
            dof = Dof(len(self._dofs), tuple((address + i).tolist()), (*above, *dofs), has_friction_loss)
            self._dofs.append(dof)
            dofs.append(dof.index)
        return Joint(
            kind=kind,
            ids=tuple(ids),
            qpos=tuple(model.jnt_qposadr[list(ids)].tolist()),
            dof=tuple(address.tolist()),
            dofs=tuple(dofs),
            limited=bool(model.jnt_limited[first]),
            motors=tuple(Motor(slot) for slot in zip(*(self._motors(j) for j in ids), strict=True)),
        )


def _merged(touches: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """The points of a single body side by side, as one array each."""
    alike: dict[Any, list[Candidate]] = {}
    for touch in touches:
        alike.setdefault(touch.signature, []).append(touch)
    return tuple(Candidate.joined(members) for members in alike.values())
