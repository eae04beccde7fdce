"""Which terms of an unknown law the forces that a joint lacks suggest, and with which values.

Each term of the library is laid beside the missing force, at many values of its shape; compared is what is left of both
without what wrong values of the model would explain. A look only: what the terms do is found in the simulation.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from estexp_jax.discovery.force_residual import ForceResidual
from estexp_jax.discovery.hypotheses import Place
from estexp_jax.discovery.starts import Vectors
from estexp_jax.physics.changes import Change
from estexp_jax.physics.effects.base import JointMoment
from estexp_jax.physics.effects.laws.base import Course, JointLaw, Reach
from estexp_jax.physics.registry import LAWS, effect
from estexp_jax.physics.robot import Robot

_SAMPLES, _COLUMNS = 2000, 64
"""Samples of the forces, and values of shapes laid beside them at once."""
_STARTS = 4
"""Values that are kept of a term."""
_JOLT = 0.995
"""Quantile of the force beyond which it is cut off: jolts are smeared by smoothing."""
_LITTLE = 1e-3
"""Share of the largest amplitude at which a force is still in proportion to it."""
_ALIKE = 1e-6
"""Share of a force's square; if less than that is left of it, it is what wrong values of the model look like."""
_FAST = 0.98
"""Quantile of the speed that counts as fast, and of the motor torque that counts as hard."""


class _Samples(NamedTuple):
    """What was seen of a joint, (samples,); position, speed and motor torque of the others by index."""

    force: np.ndarray
    q: np.ndarray
    w: np.ndarray
    motor: np.ndarray
    bent: np.ndarray  # (samples, n) orthonormal: what wrong values of the model would look like
    others: Mapping[int, tuple[np.ndarray, np.ndarray, np.ndarray]]
    runs: tuple[Course, ...]  # of each recording, unthinned
    thin: tuple[np.ndarray, ...]  # which rows of each recording count
    reach: Reach


class _Beside(NamedTuple):
    """A term at some values beside the missing force: share of its square that it takes out."""

    share: float
    values: tuple[float, ...]


def likely(
    robot: Robot, seen: Sequence[ForceResidual], joint: str, n: int, named: Collection[str] = ()
) -> dict[Place, Vectors]:
    """The terms at a joint that take out most of the force that it lacks, with values to start from.

    Args:
        robot: the nominal robot.
        seen: what its joints lack, in each training recording.
        joint: the joint's name.
        n: how many terms are wanted.
        named: effects of the catalogue that may be claimed: terms that say the same do not count.
    """
    samples = _samples(robot, seen, robot.index("joint", joint))
    found = {law.name: _beside(robot, law, joint, samples) for law in LAWS if law.stands_for not in named}
    ranked = sorted((name for name in found if found[name]), key=lambda name: -found[name][0].share)
    return {(name, joint): [b.values for b in found[name]] for name in ranked[:n]}


class LawForces(NamedTuple):
    """What a law does where recordings show its joint, and what the joint lacks without it.

    Attributes:
        joint: its name.
        q, w: (samples,) position and speed, rad or m and rad/s or m/s.
        motor: (samples,) torque of its motors, N m or N.
        lacking: (samples,) force that the joint lacks, N m or N; jolts cut off.
        given: (samples,) what the law gives.
    """

    joint: str
    q: np.ndarray
    w: np.ndarray
    motor: np.ndarray
    lacking: np.ndarray
    given: np.ndarray


def law_forces(robot: Robot, seen: Sequence[ForceResidual], joint: str, terms: Sequence[Change]) -> LawForces:
    """The terms of a law along the training recordings.

    Args:
        robot: the nominal robot.
        seen: what its joints lack without the law, in each training recording.
        joint: the joint's name.
        terms: of the law, with their values.
    """
    samples, given = _samples(robot, seen, robot.index("joint", joint)), np.zeros(1)
    for term in terms:
        law = effect(term.effect)
        assert isinstance(law, JointLaw)
        given = given + _force(law, tuple(np.array([term.values[p.name]]) for p in law.parameters), samples)[:, 0]
    return LawForces(joint, samples.q, samples.w, samples.motor, samples.force, given)


def _samples(robot: Robot, seen: Sequence[ForceResidual], joint: int) -> _Samples:
    model = robot.model
    every = max(1, sum(len(r.time) for r in seen) // _SAMPLES)
    thin = tuple(np.arange(0, len(r.time), every) for r in seen)

    def joined(columns: Sequence[np.ndarray]) -> np.ndarray:
        return np.concatenate([c[rows] for c, rows in zip(columns, thin, strict=True)])

    def motion(j: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        place, dof = model.jnt_qposadr[j], model.jnt_dofadr[j]
        each = [[r.qpos[:, place] for r in seen], [r.qvel[:, dof] for r in seen], [r.motor[:, dof] for r in seen]]
        q, w, motor = map(joined, each)
        return q, w, motor

    place, dof = model.jnt_qposadr[joint], model.jnt_dofadr[joint]
    moved = [j for j in robot.scalar_joints if any(np.ptp(r.qvel[:, model.jnt_dofadr[j]]) > 0.0 for r in seen)]
    q, w, motor = motion(joint)
    force = joined([r.force[:, dof] for r in seen])
    far = float(np.quantile(np.abs(force), _JOLT))
    faster = joined([np.gradient(r.qvel[:, dof], r.time) for r in seen])
    bent, _ = np.linalg.qr(np.stack([w, motor, faster], axis=1) + 0.0)
    length = max(float(np.ptp(r.time)) for r in seen)
    others = {j: motion(j) for j in moved if j != joint}
    fast, hard = (float(np.quantile(np.abs(x), _FAST)) for x in (w, motor))
    reach = Reach(float(q.min()), float(q.max()), fast, length, hard, tuple(others))
    runs = tuple(Course(r.time - r.time[0], r.qpos[:, place], r.qvel[:, dof], r.motor[:, dof]) for r in seen)
    return _Samples(np.clip(force, -far, far), q, w, motor, bent, others, runs, thin, reach)


def _beside(robot: Robot, law: JointLaw, joint: str, samples: _Samples) -> list[_Beside]:
    """The best values of a term, the best one first; [] where it can do nothing."""
    bounds = np.array(law.bounds(robot, joint))
    shapes = [tuple(np.clip(s, *bounds[1:].T)) for s in law.tried(samples.reach)] if len(bounds) > 1 else [()]
    shapes = shapes if law.tried(samples.reach) else []
    found: list[_Beside] = []
    for part, columns in _columns(law, _LITTLE * bounds[0, 1], shapes, samples):
        found += _explained(part, columns, bounds[0], samples)
    distinct = {b.values: b for b in sorted(found, key=lambda b: b.share) if b.values[0] != 0.0}
    return list(reversed(distinct.values()))[:_STARTS]


def _explained(
    shapes: Sequence[tuple[float, ...]], columns: np.ndarray, bound: np.ndarray, samples: _Samples
) -> list[_Beside]:
    """What each column takes out of the missing force beside wrong values of the model, and alone.

    What looks like wrong values of the model takes nothing out; it is still a start, by all that it resembles.
    """
    whole = np.sum(columns**2, axis=0)
    left, force = _without(samples.bent, columns), _without(samples.bent, samples.force[:, None])[:, 0]
    found: list[_Beside] = []
    for own, y, counts in ((left, force, True), (columns, samples.force, False)):
        size, along = np.sum(own**2, axis=0), own.T @ y
        amplitude = np.where(size > _ALIKE * whole, along, 0.0) / np.maximum(size, 1e-30)
        share = amplitude * along / max(float(force @ force), 1e-30) if counts else np.zeros(len(shapes))
        share, amplitude = _allowed(share, amplitude, bound)
        values = zip(share.tolist(), amplitude.tolist(), shapes, strict=True)
        found += [_Beside(s, (a, *map(float, shape))) for s, a, shape in values]
    return found


def _allowed(share: np.ndarray, amplitude: np.ndarray, bound: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Amplitudes within their bounds; what would need another sign takes nothing out, and starts from little."""
    low, high = bound
    wrong = (amplitude < low) & (low == 0.0)
    return np.where(wrong, 0.0, share), np.where(wrong, 0.01 * high, np.clip(amplitude, low, high))


def _without(basis: np.ndarray, columns: np.ndarray) -> np.ndarray:
    return columns - basis @ (basis.T @ columns)


def _columns(
    law: JointLaw, amplitude: float, shapes: Sequence[tuple[float, ...]], samples: _Samples
) -> Iterator[tuple[Sequence[tuple[float, ...]], np.ndarray]]:
    """Shapes with the force (samples, shapes) of a term of amplitude 1 at them."""
    for first in range(0, len(shapes), _COLUMNS):
        part = shapes[first : first + _COLUMNS]
        filled = np.resize(np.array(part, float).reshape(len(part), -1), (_COLUMNS, len(part[0])))  # compiles once
        p = (np.full(_COLUMNS, amplitude), *filled.T)
        yield part, _force(law, p, samples)[:, : len(part)] / amplitude


def _force(law: JointLaw, p: tuple[np.ndarray, ...], samples: _Samples) -> np.ndarray:
    """The force (samples, shapes) of a term at values (shapes,) of each parameter, where the joint was seen."""
    q, w, motor = (x[:, None] for x in (samples.q, samples.w, samples.motor))
    one = np.ones_like(q)

    def of_others(number: np.ndarray) -> list[np.ndarray]:
        at = [samples.others[round(float(k)) - 1] for k in np.ravel(number)]
        return [np.stack(columns, axis=1) for columns in zip(*at, strict=True)]

    def motion_of(number: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        at, rate, _ = of_others(number)
        return at, rate

    def torque_of(number: np.ndarray) -> np.ndarray:
        return of_others(number)[2]

    moment = JointMoment(q, w, motor, one, np.zeros(1), one, one, lambda q, w: motor, torque_of, motion_of)
    state = _states(law, p, samples)
    does, _ = law.act(tuple(jnp.asarray(x) for x in p), moment, state)
    sign = np.tanh(w / (0.01 * max(samples.reach.speed, 1e-9)))
    total = does.force - does.damping * w - does.friction * sign + (does.motor - 1.0) * motor
    return np.asarray(jnp.broadcast_to(total, (len(samples.q), len(p[0]))), float)


def _states(law: JointLaw, p: tuple[np.ndarray, ...], samples: _Samples) -> tuple[np.ndarray, ...]:
    """The hidden variables (samples, shapes) of a term along the recordings."""
    if not law.n_states:
        return ()
    each = []
    for values in zip(*p, strict=True):
        parts = [law.remembered(values, course) for course in samples.runs]
        each.append(
            [
                np.concatenate([part[k][rows] for part, rows in zip(parts, samples.thin, strict=True)])
                for k in range(law.n_states)
            ]
        )
    return tuple(np.stack([one[k] for one in each], axis=1) for k in range(law.n_states))
